"""Headless Chromium over its debugging pipe: no driver, no network, nothing but the browser."""

from __future__ import annotations

import json
import os
import select
import shutil
import subprocess
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

    def wait_for(self, expression: str) -> bool:
        """Whether the expression comes true before the time is up."""
        end = time.monotonic() + self._timeout_s
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
    to_read, to_write = os.pipe()
    from_read, from_write = os.pipe()
    # The browser reads descriptor 3 and writes 4; sh moves ours there.
    script = f'exec "$0" "$@" 3<&{to_read} 4>&{from_write}'
    command = ["sh", "-c", script, program, *_FLAGS, f"--user-data-dir={profile}", "about:blank"]
    process = subprocess.Popen(
        command,
        pass_fds=(to_read, from_write),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(to_read)
    os.close(from_write)
    try:
        yield Page(to_write, from_read, timeout_s)
    finally:
        os.close(to_write)
        os.close(from_read)
        process.terminate()
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        shutil.rmtree(profile, ignore_errors=True)
