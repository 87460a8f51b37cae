"""Progress of what takes longer than a few seconds: bars on a terminal, a line now and then
elsewhere."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from typing import TYPE_CHECKING, Protocol, TextIO

if TYPE_CHECKING:
    from rich.progress import Progress as Bars
    from rich.progress import TaskID

PATIENCE_S = 2.0
# A log is read afterwards: what is over in a few seconds is not told there, and the rest seldom.
LINE_PATIENCE_S, LINE_EVERY_S = 5.0, 10.0


class Task(Protocol):
    """One piece of work under way."""

    def advance(self, steps: int = 1) -> None:
        """So many of the total are done."""


class Progress(Protocol):
    """Where work tells how far it is: ``with progress.task("Computing sets", total=n) as t:``."""

    def task(self, title: str, total: int | None = None) -> AbstractContextManager[Task]:
        """A piece of work; ``total`` in the units of ``advance``, None where nobody knows."""


class Silent:
    """Progress that nobody watches."""

    @contextmanager
    def task(self, title: str, total: int | None = None) -> Iterator[Task]:
        """See ``Progress.task``."""
        yield _SilentTask()


class _SilentTask:
    def advance(self, steps: int = 1) -> None:
        pass


class TerminalProgress:
    """Bars on a terminal, each shown once its work has lasted ``patience_s``, gone when done.

    Tasks may be nested; all are used from one thread.
    """

    def __init__(self, stream: TextIO, patience_s: float = PATIENCE_S) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
        from rich.progress import Progress as Bars

        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
        )
        console = Console(file=stream, force_terminal=True)
        self._bars = Bars(*columns, console=console, transient=True)
        self._patience_s = patience_s
        self._lock = threading.Lock()

    @contextmanager
    def task(self, title: str, total: int | None = None) -> Iterator[Task]:
        """See ``Progress.task``."""
        bar = self._bars.add_task(title, total=total, visible=False)
        # The clock shows the bar, not the work: work that never calls advance shows one as well.
        clock = threading.Timer(self._patience_s, self._show, [bar])
        clock.daemon = True
        clock.start()
        try:
            yield _Bar(self._bars, bar)
        finally:
            clock.cancel()
            with self._lock:
                self._bars.remove_task(bar)
                if not self._bars.task_ids:
                    self._bars.stop()

    def _show(self, bar: TaskID) -> None:
        with self._lock:
            if bar in self._bars.task_ids:
                self._bars.update(bar, visible=True)
                self._bars.start()


class _Bar:
    def __init__(self, bars: Bars, bar: TaskID) -> None:
        self._bars, self._bar = bars, bar

    def advance(self, steps: int = 1) -> None:
        self._bars.advance(self._bar, steps)


class LineProgress:
    """Plain lines for logs and pipes: one once work has lasted ``patience_s``, one every
    ``every_s`` from then on, and one at its end if there were any."""

    def __init__(
        self,
        stream: TextIO,
        patience_s: float = LINE_PATIENCE_S,
        every_s: float = LINE_EVERY_S,
    ) -> None:
        self._stream = stream
        self._patience_s, self._every_s = patience_s, every_s

    @contextmanager
    def task(self, title: str, total: int | None = None) -> Iterator[Task]:
        """See ``Progress.task``."""
        task, over = _Counted(title, total), threading.Event()

        def watch() -> None:
            wait = self._patience_s
            while not over.wait(wait):
                self._tell(task.line())
                wait = self._every_s

        # The clock tells, not the work: work that never calls advance is told of as well.
        clock = threading.Thread(target=watch, daemon=True)
        clock.start()
        done = False
        try:
            yield task
            done = True
        finally:
            over.set()
            clock.join()
            if done and task.told:
                self._tell(f"{title}: done, {task.seconds:.0f} s")

    def _tell(self, line: str) -> None:
        with suppress(OSError, ValueError):  # nobody reads any more: the work goes on
            self._stream.write(f"servogen: {line}\n")
            self._stream.flush()


class _Counted:
    def __init__(self, title: str, total: int | None) -> None:
        self._title, self._total = title, total
        self._done, self._began = 0, time.monotonic()
        self.told = False

    @property
    def seconds(self) -> float:
        return time.monotonic() - self._began

    def advance(self, steps: int = 1) -> None:
        self._done += steps

    def line(self) -> str:
        self.told = True
        of = "" if self._total is None else f" of {self._total}"
        count = f"{self._done}{of}, " if self._done or of else ""
        return f"{self._title}: {count}{self.seconds:.0f} s"


def for_stream(stream: TextIO) -> Progress:
    """Bars where ``stream`` is a terminal, seldom lines elsewhere."""
    return TerminalProgress(stream) if stream.isatty() else LineProgress(stream)
