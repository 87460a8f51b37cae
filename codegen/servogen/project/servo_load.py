"""From a servo drive's TOML file to a ServoProject: read, validated and resolved once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from servogen.errors import InputError
from servogen.project.servo_consistency import check_servo
from servogen.project.servo_reference import SineReference, TrapezoidReference
from servogen.project.servo_schema import (
    Axis,
    MatricesDrive,
    ServoController,
    ServoFile,
    ServoOutput,
    ServoSampling,
    ServoTarget,
    TwoMassDrive,
)
from servogen.project.toml_text import read_toml
from servogen.project.translate import to_input_error, value_text


@dataclass(frozen=True)
class ServoProject:
    """A validated project; its fields mirror the tables of the file.

    Attributes:
        file: the project file as it was named to ``load_servo_project``.
        ratio: samples of the current loop in one of position control.
    """

    file: Path
    name: str
    system: str
    drive: TwoMassDrive | MatricesDrive
    axis: Axis
    sampling: ServoSampling
    controller: ServoController
    reference: SineReference | TrapezoidReference
    output: ServoOutput
    target: ServoTarget

    @property
    def sources(self) -> tuple[Path, ...]:
        """Every file that the drive is made from."""
        return (self.file,)

    @property
    def ratio(self) -> int:
        return round(self.sampling.sample_time_s / self.sampling.current_sample_time_s)

    def error(self, key: str, value: object, expected: str) -> InputError:
        """An InputError about a key of this project's file, to be raised by the caller."""
        return InputError(self.file, key, value_text(value), expected)

    def fault(self, key: str, said: object, expected: str) -> InputError:
        """The same about what was found out beyond the file: words are told as they are."""
        told = said if said is None or isinstance(said, str) else value_text(said)
        return InputError(self.file, key, told, expected)


def load_servo_project(path: Path) -> ServoProject:
    """Read and validate the project file of a servo drive.

    Raises:
        InputError: the file cannot be read, is no TOML, or breaks the schema or a relation
            between its keys. What asks for the plant is judged later, in ``systems.servo_drive``.
    """
    path = Path(path)
    try:
        return _build(path, read_toml(path))
    except RecursionError:
        raise InputError(path, "the file", None, "tables nested a few levels deep") from None


def _build(path: Path, raw: dict[str, Any]) -> ServoProject:
    try:
        found = ServoFile.model_validate(raw, context={"folder": path.parent})
    except ValidationError as error:
        raise to_input_error(path, raw, error, ServoFile) from None
    project = ServoProject(
        file=path,
        name=found.name,
        system=found.system,
        drive=found.drive,
        axis=found.axis,
        sampling=found.sampling,
        controller=found.controller,
        reference=found.reference,
        output=found.output,
        target=found.target,
    )
    check_servo(project)
    return project
