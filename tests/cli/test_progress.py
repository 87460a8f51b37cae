"""Progress is told on a terminal, after a while, and nowhere else."""

from __future__ import annotations

import io
import time

import pytest

from servogen.progress import Silent, TerminalProgress, for_stream


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def test_only_a_terminal_gets_bars() -> None:
    assert isinstance(for_stream(io.StringIO()), Silent)
    assert isinstance(for_stream(Terminal()), TerminalProgress)


def test_silence_is_silent() -> None:
    with Silent().task("Counting", total=3) as task:
        task.advance()
        task.advance(2)


def test_short_work_shows_nothing() -> None:
    stream = Terminal()
    progress = TerminalProgress(stream, patience_s=5.0)
    with progress.task("Counting", total=3) as task:
        task.advance(3)
    assert stream.getvalue() == ""


def test_long_work_shows_its_bars_nested_ones_as_well() -> None:
    stream = Terminal()
    progress = TerminalProgress(stream, patience_s=0.01)
    with progress.task("Comparing", total=4) as outer:
        with progress.task("Compiling"):
            time.sleep(0.3)
        outer.advance(3)
        time.sleep(0.3)
    told = stream.getvalue()
    assert "Comparing" in told
    assert "Compiling" in told
    assert "3/4" in told


def test_an_interrupt_takes_the_bar_away() -> None:
    stream = Terminal()
    progress = TerminalProgress(stream, patience_s=0.01)

    def work() -> None:
        with progress.task("Comparing", total=4):
            time.sleep(0.2)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        work()
    shown = stream.getvalue()
    time.sleep(0.2)
    assert stream.getvalue() == shown  # nothing draws any more
    assert shown.count("\x1b[?25l") == shown.count("\x1b[?25h")  # the cursor is back
