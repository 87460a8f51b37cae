"""The taut string of a whole path at the speed of C: same bits as ``taut_string``, long paths only.

``c_runtime/sg_taut.h`` is the C that the streamed controller emits too. It is compiled once in a
process, in a folder that is gone when it is loaded.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import cffi
import numpy as np

from servogen.errors import ServogenError
from servogen.paths.curves import FloatArray
from servogen.resources import resource_dir

# No contraction and no reordering: the reference's bits.
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fno-wrapv", "-Wall", "-Wextra", "-Werror")
_PROTOTYPE = """
int32_t sg_minimal_motion(int32_t n, const double *lower, const double *upper, double start,
                          int32_t *low, int32_t *high, double *x);
"""


class KernelError(ServogenError):
    """The kernel did not compile: a fault of servogen or of the compiler, not of the input."""

    exit_status = 1


def has_compiler() -> bool:
    """Whether there is a gcc."""
    return shutil.which("gcc") is not None


@cache
def _kernel() -> tuple[Any, Any]:
    """cffi's ``ffi`` and the library.

    Raises:
        KernelError: the compiler refused.
    """
    ffi = cffi.FFI()
    ffi.cdef(_PROTOTYPE)
    source = resource_dir("c_runtime") / "host" / "sg_minimal_motion.c"
    with tempfile.TemporaryDirectory(prefix="servogen-host-") as folder:
        library = Path(folder) / "libminimal_motion.so"
        command = ["gcc", *FLAGS, "-shared", "-fPIC", str(source), "-o", str(library)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise KernelError(f"the minimal motion's kernel does not compile: {done.stderr}")
        return ffi, ffi.dlopen(str(library))


def taut_string_compiled(
    lower: FloatArray, upper: FloatArray, start: float
) -> tuple[FloatArray, int]:
    """The string at every point (n,) and its look-ahead (``Knots.look_ahead``).

    Args:
        lower, upper: (n,) float64, contiguous, n below 2^31.
        start: the string one point before the first.

    Raises:
        KernelError: the compiler refused.
    """
    ffi, library = _kernel()
    size = len(lower)
    low, high = np.empty(size, dtype=np.int32), np.empty(size, dtype=np.int32)
    x = np.empty(size)
    ahead = library.sg_minimal_motion(
        size,
        ffi.from_buffer("double[]", lower),
        ffi.from_buffer("double[]", upper),
        start,
        ffi.from_buffer("int32_t[]", low, require_writable=True),
        ffi.from_buffer("int32_t[]", high, require_writable=True),
        ffi.from_buffer("double[]", x, require_writable=True),
    )
    return x, int(ahead)
