"""Headless Chromium over its debugging pipe: no driver, no network, nothing but the browser."""

from __future__ import annotations

import fcntl
import json
import os
import select
import shutil
import signal
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

PROGRAMS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
_FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--hide-scrollbars",
    "--remote-debugging-pipe",
)


class BrowserError(RuntimeError):
    """No browser, or one that does not answer."""


def find_chromium() -> str:
    """The browser's program.

    Raises:
        BrowserError: there is none; says which package has it.
    """
    for name in PROGRAMS:
        found = shutil.which(name)
        if found:
            return found
    raise BrowserError("no Chromium here: apt-get install chromium")


class Page:
    """One page: send commands of the DevTools protocol, collect what it reports."""

    def __init__(self, to_browser: int, from_browser: int, timeout_s: float) -> None:
        self._write, self._read = to_browser, from_browser
        self._timeout_s = timeout_s
        self._buffer = b""
        self._last_id = 0
        self._session: str | None = None
        self.events: list[dict[str, Any]] = []
        target = self.send("Target.createTarget", url="about:blank")["targetId"]
        attached = self.send("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Runtime", "Log", "Network", "Page"):
            self.send(f"{domain}.enable")

    def send(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Do it and wait for its result."""
        self._last_id += 1
        message: dict[str, Any] = {"id": self._last_id, "method": method, "params": parameters}
        if self._session is not None:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._receive()
            if answer.get("id") != self._last_id:
                self.events.append(answer)
            elif "error" in answer:
                raise BrowserError(f"{method}: {answer['error'].get('message')}")
            else:
                return dict(answer["result"])

    def evaluate(self, expression: str) -> Any:
        """Value of a JavaScript expression, promises awaited."""
        answer = self.send(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        if "exceptionDetails" in answer:
            raise BrowserError(f"the page threw: {answer['exceptionDetails'].get('text')}")
        return answer["result"].get("value")

    def wait_for(self, expression: str, patience_s: float) -> bool:
        """Whether the expression comes true before the time is up."""
        end = time.monotonic() + patience_s
        while time.monotonic() < end:
            if self.evaluate(f"Boolean({expression})"):
                return True
            time.sleep(0.1)
        return False

    def _receive(self) -> dict[str, Any]:
        end = time.monotonic() + self._timeout_s
        while b"\0" not in self._buffer:
            ready, _, _ = select.select([self._read], [], [], max(end - time.monotonic(), 0.0))
            part = os.read(self._read, 1 << 20) if ready else b""
            if not part:
                raise BrowserError(
                    "Chromium ended" if ready else f"no answer within {self._timeout_s:g} s"
                )
            self._buffer += part
        text, self._buffer = self._buffer.split(b"\0", 1)
        return dict(json.loads(text))


@contextmanager
def open_page(timeout_s: float = 60.0) -> Iterator[Page]:
    """An empty page of a browser of its own, which ends with the block.

    Raises:
        BrowserError: no Chromium, or it does not answer.
    """
    program = find_chromium()
    profile = tempfile.mkdtemp(prefix="servogen-browser-")
    to_read, to_write = _high_pipe()
    from_read, from_write = _high_pipe()
    arguments = [program, *_FLAGS, f"--user-data-dir={profile}", "about:blank"]
    # posix_spawn, since the browser wants its pipes as descriptors 3 and 4
    actions: list[tuple[Any, ...]] = [
        (os.POSIX_SPAWN_OPEN, 0, os.devnull, os.O_RDONLY, 0),
        (os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0),
        (os.POSIX_SPAWN_OPEN, 2, os.devnull, os.O_WRONLY, 0),
        (os.POSIX_SPAWN_DUP2, to_read, 3),
        (os.POSIX_SPAWN_DUP2, from_write, 4),
    ]
    process = os.posix_spawn(program, arguments, os.environ, file_actions=actions)
    os.close(to_read)
    os.close(from_write)
    try:
        yield Page(to_write, from_read, timeout_s)
    except BrokenPipeError as error:
        raise BrowserError("Chromium ended before it was asked anything") from error
    finally:
        os.close(to_write)
        os.close(from_read)
        _end(process)
        shutil.rmtree(profile, ignore_errors=True)


def _high_pipe() -> tuple[int, int]:
    """A pipe whose descriptors are not among those that the browser is given."""
    low = os.pipe()
    high = [fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 10) for end in low]
    for end in low:
        os.close(end)
    return high[0], high[1]


def _end(process: int) -> None:
    """Ask it to end, make it end after ten seconds."""
    os.kill(process, signal.SIGTERM)
    end = time.monotonic() + 10.0
    while os.waitpid(process, os.WNOHANG)[0] == 0:
        if time.monotonic() > end:
            os.kill(process, signal.SIGKILL)
        time.sleep(0.02)
