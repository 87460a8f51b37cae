"""G-code to strokes: the moves of a program, in its order, in x and y or in all three axes.

What is understood: G0 G1 G2 G3 (modal), G17, G20 G21, G90 G91, I J from the start of an arc or R
(below 0 for the longer arc), Z in straight moves and in arcs, which are helices then, F in units
per minute along the path, N. A program without a Z is a plane one. Without G20 or G21 a unit is a
millimetre.
What asks for what is done anyway is accepted: G40 G49 G54 G61 G64 G80 G91.1 G94; spindle, laser
and coolant words (M3 M4 M5 M7 M8 M9, S, T) say nothing about the path. M2 and M30 end the program.
Everything else is refused, since it would change the path or stop on it.

G0 is a straight move at the traverse feed. The tool begins at the origin, but the path begins
where the first G1, G2 or G3 does: the G0 moves before it only say where that is.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from servogen.errors import InputError
from servogen.paths.curves import EllipticArc, Helix, Line, Segment, Stroke
from servogen.paths.gcode_arcs import ArcError, arc_by_center, arc_by_radius
from servogen.paths.gcode_words import Block, read_blocks
from servogen.paths.settings import PathSettings

_MOTIONS = (0.0, 1.0, 2.0, 3.0)
_NO_EFFECT = (17.0, 40.0, 49.0, 54.0, 61.0, 64.0, 80.0, 91.1, 94.0)
_IGNORED_M = (3.0, 4.0, 5.0, 7.0, 8.0, 9.0)
_ENDS = (2.0, 30.0)
_G_EXPECTED = "one of G0 G1 G2 G3 G17 G20 G21 G90 G91 G94"
_M_EXPECTED = "one of M2 M30 M3 M4 M5 M7 M8 M9"


def read_gcode(file: Path, settings: PathSettings) -> list[Stroke]:
    """One stroke for each move that has a length, labelled with its line.

    Raises:
        InputError: naming the line with an unsupported word or code, a contradictory arc, or a
            feed that is not above 0.
    """
    program = _Program(file, settings)
    for block in read_blocks(file):
        program.run(block)
        if program.ended:
            break
    return program.strokes


@dataclass(frozen=True)
class _Move:
    """A move in the plane and the heights at its ends."""

    label: str
    flat: Segment
    heights: tuple[float, float]
    feed_m_per_s: float | None

    def stroke(self, deep: bool) -> Stroke:
        """In two axes, or in three."""
        segment = self.flat
        if deep and isinstance(segment, Line):
            start, end = self.heights
            segment = Line((*segment.start, start), (*segment.end, end))
        elif deep and isinstance(segment, EllipticArc):
            segment = Helix(segment, *self.heights)
        return Stroke(self.label, (segment,), self.feed_m_per_s)


class _Program:
    """The modal state of a controller, and the moves so far."""

    def __init__(self, file: Path, settings: PathSettings) -> None:
        self.file = file
        self.settings = settings
        self.moves: list[_Move] = []
        self.deep = False
        self.ended = False
        self.at = (0.0, 0.0)
        self.height = 0.0
        self.motion: float | None = None
        self.unit_m = 1e-3
        self.relative = False
        self.feed_m_per_s: float | None = None

    @property
    def strokes(self) -> list[Stroke]:
        """Of all moves, in three axes as soon as one line speaks of z."""
        return [move.stroke(self.deep) for move in self.moves]

    def run(self, block: Block) -> None:
        """Carry out one line: settings first, then the move, then the end of the program."""
        values = self._settings(block)
        places = {letter: self.unit_m * values[letter] for letter in "XYZIJR" if letter in values}
        if "F" in values:
            self._set_feed(block, values["F"])
        if places:
            self._move(block, places)

    def _settings(self, block: Block) -> dict[str, float]:
        """Apply a line's codes; the words that are left, by letter."""
        values: dict[str, float] = {}
        motions = []
        for letter, value in block.words:
            if letter == "G":
                if value in _MOTIONS:
                    motions.append(value)
                else:
                    self._set_mode(block, value)
            elif letter == "M":
                self._machine_code(block, value)
            elif letter in values:
                self._refuse(block, f"with {letter} twice", f"each of {letter} once in a line")
            else:
                values[letter] = value
        if len(motions) > 1:
            self._refuse(block, "with more than one of G0 G1 G2 G3", "one motion in a line")
        self.motion = motions[0] if motions else self.motion
        return values

    def _set_mode(self, block: Block, code: float) -> None:
        if code in (20.0, 21.0):
            self.unit_m = 0.0254 if code == 20.0 else 1e-3
        elif code in (90.0, 91.0):
            self.relative = code == 91.0
        elif code not in _NO_EFFECT:
            self._refuse(block, f"G{code:g}", _G_EXPECTED)

    def _machine_code(self, block: Block, code: float) -> None:
        if code in _ENDS:
            self.ended = True
        elif code not in _IGNORED_M:
            self._refuse(block, f"M{code:g}", _M_EXPECTED)

    def _set_feed(self, block: Block, value: float) -> None:
        if not value > 0.0:
            self._refuse(block, f"F{value:g}", "a feed above 0")
        self.feed_m_per_s = value * self.unit_m / 60.0

    def _move(self, block: Block, places: dict[str, float]) -> None:
        if self.motion is None:
            self._refuse(block, "a move without a motion", "G0, G1, G2 or G3 before or in it")
        x, y = self.at
        base = self.at if self.relative else (0.0, 0.0)
        target = (
            base[0] + places["X"] if "X" in places else x,
            base[1] + places["Y"] if "Y" in places else y,
        )
        height = self.height
        if "Z" in places:
            self.deep = True
            height = places["Z"] + (height if self.relative else 0.0)
        extra = [letter for letter in "IJR" if letter in places]
        if self.motion in (0.0, 1.0):
            if extra:
                self._refuse(block, f"{extra[0]} in a straight move", "X, Y and Z only")
            segment: Segment = Line(self.at, target)
        else:
            segment = self._arc(block, target, places)
        self._cut(block, segment, height)
        self.at, self.height = target, height

    def _arc(self, block: Block, target: tuple[float, float], places: dict[str, float]) -> Segment:
        clockwise = self.motion == 2.0
        by_center = "I" in places or "J" in places
        if by_center == ("R" in places):
            how = "with a centre and a radius" if by_center else "without centre and radius"
            self._refuse(block, f"an arc {how}", "I and J, or R")
        try:
            if by_center:
                offset = (places.get("I", 0.0), places.get("J", 0.0))
                return arc_by_center(self.at, target, offset, clockwise)
            return arc_by_radius(self.at, target, places["R"], clockwise)
        except ArcError as error:
            raise InputError(self.file, block.label, error.value, error.expected) from error

    def _cut(self, block: Block, segment: Segment, height: float) -> None:
        """Add a move; moves without a length and the G0s at the beginning are not cut."""
        level = height == self.height
        nowhere = level and isinstance(segment, Line) and segment.start == segment.end
        if not nowhere and (self.motion != 0.0 or self.moves):
            feed = self.settings.traverse_feed_m_per_s if self.motion == 0.0 else self.feed_m_per_s
            self.moves.append(_Move(block.label, segment, (self.height, height), feed))

    def _refuse(self, block: Block, value: str, expected: str) -> NoReturn:
        raise InputError(self.file, block.label, value, expected)
