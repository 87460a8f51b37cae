"""Processes of outside tools, and work on several of them at a time: an interruption ends them all.

Each child leads a process group of its own, so that what it has started ends with it.
"""

from __future__ import annotations

import os
import signal
import subprocess
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from contextlib import suppress
from pathlib import Path
from typing import TypeVar

_GRACE_S = 10.0  # to tidy up: the build of a compiler removes a gigabyte
_lock = threading.Lock()
_running: set[subprocess.Popen[bytes]] = set()
_ending = threading.Event()

Job = TypeVar("Job")
Result = TypeVar("Result")


class Ended(BaseException):
    """In a thread of ``in_order`` whose work is no longer wanted: no tool is started any more."""


def run_child(
    command: Sequence[str],
    folder: Path | None,
    given: bytes | None,
    env: Mapping[str, str],
    patience_s: float,
) -> subprocess.CompletedProcess[bytes]:
    """Run to the end, with ``given`` as its input or none; whatever ends the wait ends the child.

    Raises:
        subprocess.TimeoutExpired: it has not ended after ``patience_s``.
        OSError: it cannot be started.
    """
    with _lock:
        if _ending.is_set():
            raise Ended
        child = subprocess.Popen(
            command,
            cwd=folder,
            stdin=subprocess.DEVNULL if given is None else subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=env,
            process_group=0,
        )
        _running.add(child)
    try:
        out, err = child.communicate(given, timeout=patience_s)
    except BaseException:
        _end([child])
        raise
    finally:
        with _lock:
            _running.discard(child)
    return subprocess.CompletedProcess(command, child.returncode, out, err)


def in_order(work: Callable[[Job], Result], jobs: Sequence[Job], workers: int) -> Iterator[Result]:
    """What ``work`` makes of each job, several at a time, in the order of the jobs.

    The first that raises, or an interruption, ends it: what has not begun is not, and the tools
    that others run are killed.
    """
    pool = ThreadPoolExecutor(max_workers=workers)
    try:
        futures = [pool.submit(work, job) for job in jobs]
        open_ones = set(futures)
        for future in futures:
            while not future.done():
                done, open_ones = wait(open_ones, return_when=FIRST_COMPLETED)
                for each in done:
                    each.result()  # raises what went wrong, whosever turn it is
            yield future.result()
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        with _lock:
            _ending.set()
            children = list(_running)
        try:
            _end(children)
            pool.shutdown(wait=True)
        finally:
            _ending.clear()
        raise
    pool.shutdown()


def _end(children: Sequence[subprocess.Popen[bytes]]) -> None:
    """Ask all and their children to end; kill what has not done so after a while."""
    for child in children:
        _signal(child, signal.SIGTERM)
    for child in children:
        try:
            child.wait(_GRACE_S)
        except subprocess.TimeoutExpired:
            pass
        finally:
            _signal(child, signal.SIGKILL)  # what it left behind in its group, too
            child.wait()


def _signal(child: subprocess.Popen[bytes], number: signal.Signals) -> None:
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(child.pid, number)
