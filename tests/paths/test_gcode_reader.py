"""G-code: units, modes, arcs, words."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from drawings import SETTINGS, dense, ends, middle, text_file
from numpy.testing import assert_allclose

from servogen.errors import InputError
from servogen.paths.curves import EllipticArc, Helix, Line, Stroke
from servogen.paths.gcode import read_gcode
from servogen.paths.gcode_arcs import arc_by_center, arc_by_radius


def strokes(folder: Path, *lines: str) -> list[Stroke]:
    return read_gcode(text_file(folder, "part.nc", "\n".join(lines)), SETTINGS)


def only_arc(folder: Path, *lines: str) -> EllipticArc:
    arc = strokes(folder, *lines)[-1].segments[0]
    assert isinstance(arc, EllipticArc)
    return arc


def test_inches_scale_places_and_feeds(tmp_path: Path) -> None:
    (stroke,) = strokes(tmp_path, "G20 G1 X2 Y-1 F60")
    assert_allclose(ends(stroke), [[0, 0], [0.0508, -0.0254]])
    assert stroke.feed_m_per_s == pytest.approx(0.0254)


def test_millimetres_are_the_default_and_modes_can_change(tmp_path: Path) -> None:
    a, b, c = strokes(tmp_path, "G1 X10 F600", "G20 X1", "G21 Y-3")
    assert_allclose([ends(s)[1] for s in (a, b, c)], [[0.01, 0], [0.0254, 0], [0.0254, -0.003]])
    assert [s.feed_m_per_s for s in (a, b, c)] == pytest.approx([0.01] * 3)


def test_relative_moves(tmp_path: Path) -> None:
    a, b, c = strokes(tmp_path, "G0 X5 Y5", "G91 G1 X1", "Y2", "G90 X0")
    assert_allclose(ends(a), [[0.005, 0.005], [0.006, 0.005]])
    assert_allclose(ends(b)[1], [0.006, 0.007])
    assert_allclose(ends(c)[1], [0.0, 0.007])


def test_lines_are_named_comments_and_case_and_spaces_ignored(tmp_path: Path) -> None:
    program = (
        "%",
        "(one; two G1 X99)",
        "",
        "n7g1 x 1 .5y-2.",
        "; G1 X50",
        "X+3.(X9)Y.25;Z9",
        "/X4",
    )
    got = strokes(tmp_path, *program)
    assert [stroke.label for stroke in got] == ["line 4", "line 6"]
    assert_allclose(ends(got[1]), [[0.0015, -0.002], [0.003, 0.00025]])


def test_what_follows_the_end_is_not_read(tmp_path: Path) -> None:
    assert len(strokes(tmp_path, "G1 X1", "M30", "G1 X2", "nonsense!")) == 1
    assert len(strokes(tmp_path, "G1 X1 M2", "G5")) == 1


def test_the_path_begins_where_cutting_does(tmp_path: Path) -> None:
    got = strokes(tmp_path, "G0 X10", "G0 Y10", "G1 X20 F600", "G0 X0 Y0")
    assert_allclose(ends(got[0]), [[0.01, 0.01], [0.02, 0.01]])
    assert got[1].feed_m_per_s == SETTINGS.traverse_feed_m_per_s


def test_without_f_the_project_decides(tmp_path: Path) -> None:
    assert strokes(tmp_path, "G1 X1")[0].feed_m_per_s is None


def test_words_that_say_nothing_about_the_path(tmp_path: Path) -> None:
    got = strokes(
        tmp_path, "G17 G40 G49 G54 G64 G80 G91.1 G94 T1", "M3 S1000", "M8", "G1 X1", "M5 M9"
    )
    assert len(got) == 1


@pytest.mark.parametrize(
    ("line", "half_way"),
    [
        ("G2 X10 Y10 I10 J0", (10 - 10 * math.sqrt(0.5), 10 * math.sqrt(0.5))),
        ("G3 X10 Y10 I0 J10", (10 * math.sqrt(0.5), 10 - 10 * math.sqrt(0.5))),
        ("G2 X10 Y10 R10", (10 - 10 * math.sqrt(0.5), 10 * math.sqrt(0.5))),
        ("G3 X10 Y10 R10", (10 * math.sqrt(0.5), 10 - 10 * math.sqrt(0.5))),
        ("G2 X10 Y10 R-10", (-10 * math.sqrt(0.5), 10 + 10 * math.sqrt(0.5))),
        ("G3 X10 Y10 R-10", (10 + 10 * math.sqrt(0.5), -10 * math.sqrt(0.5))),
    ],
)
def test_arcs(tmp_path: Path, line: str, half_way: tuple[float, float]) -> None:
    arc = only_arc(tmp_path, line)
    assert_allclose(middle(arc), 1e-3 * np.array(half_way), atol=1e-15)
    assert_allclose(dense(arc, 2), [[0, 0], [0.01, 0.01]], atol=1e-15)
    assert math.hypot(*arc.major) == pytest.approx(0.01)


@pytest.mark.parametrize(("code", "sign"), [("G2", -1.0), ("G3", 1.0)])
def test_full_circles(tmp_path: Path, code: str, sign: float) -> None:
    for line in (f"{code} I5", f"{code} X0 Y0 I5 J0"):
        arc = only_arc(tmp_path, line)
        assert arc.t1 - arc.t0 == pytest.approx(sign * 2.0 * math.pi)
        assert_allclose(middle(arc), [0.01, 0.0], atol=1e-15)


def test_centres_are_from_the_start_in_either_mode(tmp_path: Path) -> None:
    for mode, target in (("G90", "X30 Y10"), ("G91", "X10 Y10")):
        arc = only_arc(tmp_path, "G0 X20 Y0", f"{mode} G3 {target} I0 J10")
        assert_allclose(arc.center, [0.02, 0.01])


def test_rounded_arcs_meet_both_ends(tmp_path: Path) -> None:
    arc = only_arc(tmp_path, "G0 X10", "G3 X7.071 Y7.071 I-10 J0")
    assert_allclose(dense(arc, 2), [[0.01, 0], [0.007071, 0.007071]], atol=1e-15)


def test_a_nearly_full_circle_stays_where_it_is() -> None:
    arc = arc_by_center((0.01, 0.0), (0.010001, -1e-7), (-0.01, 0.0), False)
    assert abs(arc.t1 - arc.t0) > 6.28
    assert arc.center == (0.0, 0.0)


def test_a_half_circle_by_radius_forgives_rounding() -> None:
    arc = arc_by_radius((0.0, 0.0), (0.010001, 0.0), 0.005, True)
    assert isinstance(arc, EllipticArc)
    assert_allclose(middle(arc), [0.0050005, 0.0050005], atol=1e-12)


def test_a_huge_radius_is_a_line() -> None:
    assert isinstance(arc_by_radius((0.0, 0.0), (0.01, 0.0), 1e9, True), Line)


def test_a_z_makes_a_program_of_three_axes(tmp_path: Path) -> None:
    got = strokes(tmp_path, "G0 X5 Z2", "G1 X10 F600", "G1 X20 Z-3", "G91 G1 Z1", "M2", "Z9")
    assert_allclose(ends(got[0]), [[0.005, 0, 0.002], [0.01, 0, 0.002]])
    assert_allclose(ends(got[1])[1], [0.02, 0, -0.003])
    assert_allclose(ends(got[2]), [[0.02, 0, -0.003], [0.02, 0, -0.002]])


@pytest.mark.parametrize("code", ["G2", "G3"])
def test_an_arc_with_a_z_is_a_helix(tmp_path: Path, code: str) -> None:
    (stroke,) = strokes(tmp_path, f"{code} I5 Z-4")
    (helix,) = stroke.segments
    assert isinstance(helix, Helix)
    assert_allclose(ends(stroke), [[0, 0, 0], [0, 0, -0.004]], atol=1e-17)
    assert_allclose(middle(helix), [0.01, 0, -0.002], atol=1e-17)
    sign = -1.0 if code == "G2" else 1.0
    quarter = helix.sample(helix.arc.t0 + sign * np.array([0.5 * math.pi])).points[0]
    assert_allclose(quarter, [0.005, -sign * 0.005, -0.001], atol=1e-17)


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        (("G1 X1", "G1 A5"), "line 2 is A5, expected only words of a path"),
        (("G1 X1", "", "G5 X1"), "line 3 is G5, expected one of G0"),
        (("G18",), "line 1 is G18"),
        (("G91.5",), "line 1 is G91.5"),
        (("M6 T2",), "line 1 is M6, expected one of M2"),
        (("G1 X",), 'line 1 is unreadable at "X"'),
        (("G1 X1.2.3",), 'unreadable at ".3"'),
        (("G1 Xnan",), "line 1 is unreadable"),
        (("G1 X" + "9" * 500,), "line 1 is unreadable"),
        (("hello world",), 'line 1 is unreadable at "HELLOWORLD"'),
        (("G1 X1 (never closed",), "line 1 is unreadable"),
        (("G1 X1 X2",), "line 1 is with X twice"),
        (("G1 G2 X1 R5",), "more than one of G0 G1 G2 G3"),
        (("X1",), "a move without a motion"),
        (("G1 X1 F0",), "line 1 is F0, expected a feed above 0"),
        (("G1 X1 F-3",), "line 1 is F-3"),
        (("G1 X1 I2",), "I in a straight move"),
        (("G2 X1",), "an arc without centre and radius"),
        (("G2 X1 I1 R1",), "an arc with a centre and a radius"),
        (("G2 X10 I4 J0",), "radius 4 mm at its start and 6 mm at its end"),
        (
            ("G2 X10 R4.9",),
            "radius 4.9 mm between points 10 mm apart, expected |R| of at least 5 mm",
        ),
        (("G2 X0 Y0 R4",), "an arc by R that ends at its start"),
        (("G2 X10 I0 J0",), "an arc of radius 0"),
    ],
)
def test_refused_lines(tmp_path: Path, lines: tuple[str, ...], says: str) -> None:
    with pytest.raises(InputError) as caught:
        strokes(tmp_path, *lines)
    assert says in str(caught.value)
    assert "part.nc: line" in str(caught.value)
