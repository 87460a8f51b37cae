"""Progress is told after a while: by bars on a terminal, by a line now and then elsewhere."""

from __future__ import annotations

import io
import time
from contextlib import AbstractContextManager

import numpy as np
import pytest

from servogen.explicit.explore import solve
from servogen.progress import LineProgress, Silent, Task, TerminalProgress, for_stream
from servogen.qp.parametric import parametric_qp


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def test_only_a_terminal_gets_bars() -> None:
    assert isinstance(for_stream(io.StringIO()), LineProgress)
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


def test_a_log_gets_a_line_at_first_one_now_and_then_and_one_at_the_end() -> None:
    stream = io.StringIO()
    with LineProgress(stream, patience_s=0.05, every_s=0.2).task("Comparing", total=4) as task:
        time.sleep(0.15)
        task.advance(3)
        time.sleep(0.25)
    lines = stream.getvalue().splitlines()
    assert lines[0] == "servogen: Comparing: 0 of 4, 0 s"
    assert lines[1] == "servogen: Comparing: 3 of 4, 0 s"
    assert lines[-1] == "servogen: Comparing: done, 0 s"
    assert 3 <= len(lines) <= 4
    assert "\x1b" not in stream.getvalue()


def test_a_log_hears_nothing_of_short_work_and_no_end_of_what_failed() -> None:
    stream = io.StringIO()
    with LineProgress(stream).task("Counting", total=3) as task:
        task.advance(3)
    assert stream.getvalue() == ""

    def work() -> None:
        with LineProgress(stream, patience_s=0.01, every_s=9.0).task("Compiling"):
            time.sleep(0.1)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        work()
    assert stream.getvalue() == "servogen: Compiling: 0 s\n"


def test_a_log_that_nobody_reads_stops_no_work() -> None:
    stream = io.StringIO()
    stream.close()
    with LineProgress(stream, patience_s=0.01).task("Compiling"):
        time.sleep(0.1)


def test_the_count_of_regions_is_shown_against_the_user_s_limit() -> None:
    rng = np.random.default_rng(3)
    problem = parametric_qp(
        np.eye(2), rng.normal(size=(2, 2)), rows=rng.normal(size=(3, 2)), bounds=np.ones(3)
    )
    told: list[tuple[str, int | None]] = []

    class Watcher(Silent):
        def task(self, title: str, total: int | None = None) -> AbstractContextManager[Task]:
            told.append((title, total))
            return super().task(title, total)

    solve(problem, 77, Watcher())
    assert told == [("Computing regions, at most 77", 77)]


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
