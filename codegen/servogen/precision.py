"""The two scalar types of the emitted C, decided once per project."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.floating]
IntArray = NDArray[np.integer]
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True)
class Precision:
    """A C scalar type with the numpy type that computes the same bits.

    Attributes:
        name: ``float32`` or ``float64``, as the project file says it.
        c_type: ``float`` or ``double``.
        c_max: largest finite value, as a C literal; the finiteness test compares with it.
    """

    name: str
    c_type: str
    c_max: str

    @property
    def dtype(self) -> np.dtype[np.floating]:
        return np.dtype(self.name)

    @property
    def is_float32(self) -> bool:
        return self.name == "float32"

    @property
    def bytes(self) -> int:
        return int(self.dtype.itemsize)

    @property
    def bits(self) -> int:
        """Of a number's image, however many of them a char has."""
        return 8 * self.bytes

    @property
    def max(self) -> float:
        return float(np.finfo(self.dtype).max)


FLOAT32 = Precision("float32", "float", "3.40282347e+38f")
FLOAT64 = Precision("float64", "double", "1.7976931348623157e+308")
PRECISIONS = {p.name: p for p in (FLOAT32, FLOAT64)}
