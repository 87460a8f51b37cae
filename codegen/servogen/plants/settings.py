"""What a stage table of the project file says about its model; nothing but shapes is checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class ServoSettings:
    """``model = "servo"``: see ``plants.servo``."""

    bandwidth_rad_per_s: float
    damping: float


@dataclass(frozen=True)
class TransferFunctionSettings:
    """``model = "transfer_function"``: coefficients, descending powers of s."""

    numerator: tuple[float, ...]
    denominator: tuple[float, ...]


@dataclass(frozen=True)
class StateSpaceSettings:
    """``model = "state_space"``: continuous a (rows), b, c in any coordinates."""

    a: tuple[tuple[float, ...], ...]
    b: tuple[float, ...]
    c: tuple[float, ...]


@dataclass(frozen=True)
class PythonSettings:
    """``model = "python"``: a file whose function returns a ``SymbolicModel``; parameter values."""

    file: Path
    function: str
    parameters: Mapping[str, float] = field(default_factory=dict)


StageSettings = ServoSettings | TransferFunctionSettings | StateSpaceSettings | PythonSettings
