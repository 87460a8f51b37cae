"""SVG: units, shapes, path data, transforms."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
import pytest
from drawings import MM, SETTINGS, dense, ends, middle, svg_file, text_file
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from svgpathtools import Arc

from servogen.errors import InputError
from servogen.paths.curves import EllipticArc, Line, Nurbs, Segment
from servogen.paths.load import load_tool_path
from servogen.paths.svg import read_svg
from servogen.paths.svg_shapes import shape_chains


def segments(folder: Path, body: str, head: str = MM) -> list[Segment]:
    return [
        segment
        for stroke in read_svg(svg_file(folder, body, head), SETTINGS)
        for segment in stroke.segments
    ]


@pytest.mark.parametrize(
    ("head", "metres"),
    [
        ("", 0.0254 / 96),
        ('viewBox="0 0 7 7"', 0.0254 / 96),
        ('width="100%" height="100%" viewBox="0 0 7 7"', 0.0254 / 96),
        ('width="200" height="100"', 0.0254 / 96),
        (MM, 1e-3),
        ('width="10cm" height="20cm" viewBox="5 5 100 200"', 1e-3),
        ('width="2in" height="1in" viewBox="0,0 , 2000 1000"', 0.0254e-3),
        ('width="72pt" height="72pt" viewBox="0 0 1 1"', 0.0254),
        ('width="50mm" viewBox="0 0 100 1"', 0.5e-3),
        ('height="50mm" viewBox="0 0 1 100"', 0.5e-3),
    ],
)
def test_units_and_the_upward_axis(tmp_path: Path, head: str, metres: float) -> None:
    (line,) = segments(tmp_path, '<line x1="1" y1="2" x2="3" y2="-4"/>', head)
    assert_allclose(dense(line, 2), metres * np.array([[1, -2], [3, 4]]), rtol=1e-12)


def test_lengths_with_units_are_pixels_of_the_user_space(tmp_path: Path) -> None:
    (circle,) = segments(tmp_path, '<circle r="1in" cx="96px"/>', "")
    assert_allclose(circle.sample(np.zeros(1)).points, [[0.0508, 0.0]])


def test_shapes(tmp_path: Path) -> None:
    body = """<polyline points="0,0 10-5 1e1 5"/><polygon points="0 0 10 0 10 10"/>
              <rect x="1" y="2" width="3" height="4"/><circle cx="5" cy="5" r="2"/>
              <ellipse cx="0" cy="0" rx="3" ry="1"/><g><a><line x2="5"/></a></g>"""
    strokes = read_svg(svg_file(tmp_path, body), SETTINGS)
    kinds = ["polyline 1", "polygon 1", "rect 1", "circle 1", "ellipse 1", "line 1"]
    assert [stroke.label for stroke in strokes] == kinds
    assert [len(stroke.segments) for stroke in strokes] == [2, 3, 4, 1, 1, 1]
    for stroke in strokes[1:5]:
        assert_allclose(*ends(stroke), atol=1e-15)
    assert_allclose(ends(strokes[0]), [[0, 0], [0.01, -0.005]])
    circle = dense(strokes[3].segments[0]) - [5e-3, -5e-3]
    assert_allclose(np.hypot(*circle.T), 2e-3)


def test_rounded_rectangle(tmp_path: Path) -> None:
    """rx alone serves both; it is cut down to half a side; all arcs bulge outwards."""
    (stroke,) = read_svg(svg_file(tmp_path, '<rect width="20" height="10" rx="3"/>'), SETTINGS)
    assert [type(s) for s in stroke.segments] == [Line, EllipticArc] * 4
    for before, after in zip(stroke.segments, stroke.segments[1:], strict=False):
        assert_allclose(dense(before, 2)[1], dense(after, 2)[0], atol=1e-15)
    points = np.vstack([dense(s, 500) for s in stroke.segments])
    assert_allclose([points.min(0), points.max(0)], [[0, -0.01], [0.02, 0]], atol=1e-12)
    corner = np.hypot(points[:, 0] - 0.02, points[:, 1]).min()
    assert corner == pytest.approx(3e-3 * (math.sqrt(2) - 1), rel=1e-4)
    round_ends = segments(tmp_path, '<rect width="20" height="10" rx="99" ry="99"/>')
    assert [type(s) for s in round_ends] == [EllipticArc] * 4


def test_path_data(tmp_path: Path) -> None:
    data = "m1,1 2 0h3v-1.5.5L0 0C1 1 2 1 3 0s2-1 3 0q1 1 2 0t2 0z M50 50 l.5.5 1.e1 0"
    strokes = read_svg(svg_file(tmp_path, f'<path id="p" d="{data}"/>'), SETTINGS)
    assert [stroke.label for stroke in strokes] == ["path #p, part 1", "path #p, part 2"]
    first, second = strokes
    kinds = [Line, Line, Line, Line, Line, Nurbs, Nurbs, Nurbs, Nurbs, Line]
    assert [type(s) for s in first.segments] == kinds
    joints = np.array([dense(s, 2) for s in first.segments])
    assert_allclose(joints[1:, 0], joints[:-1, 1], atol=1e-15)
    assert_allclose(joints[-1, 1], [1e-3, -1e-3])
    assert_allclose(middle(first.segments[5]), [1.5e-3, -0.75e-3])  # (1.5, 0.75) of the cubic
    assert_allclose(ends(second), [[0.05, -0.05], [0.0605, -0.0505]])


@pytest.mark.parametrize(
    ("flags", "half_way"),
    [("0 0", (0, -5)), ("0 1", (0, 5)), ("1 0", (0, -5)), ("1 1", (0, 5))],
)
def test_half_circles_turn_as_the_sweep_flag_says(
    tmp_path: Path, flags: str, half_way: tuple[float, float]
) -> None:
    """From left to right with sweep 1 the arc passes above: y below 0 in SVG, above 0 here."""
    (arc,) = segments(tmp_path, f'<path d="M-5 0A5 5 0 {flags} 5 0"/>')
    assert_allclose(middle(arc), 1e-3 * np.array(half_way), atol=1e-12)


@settings(derandomize=True, deadline=None, max_examples=60)
@given(
    end=st.complex_numbers(min_magnitude=1.0, max_magnitude=9.0),
    rx=st.floats(1.0, 20.0),
    ry=st.floats(1.0, 20.0),
    rotation=st.floats(-180.0, 180.0),
    large=st.booleans(),
    sweep=st.booleans(),
)
def test_arcs_meet_their_ends_and_agree_with_svgpathtools(
    end: complex, rx: float, ry: float, rotation: float, large: bool, sweep: bool
) -> None:
    data = f"M1 2 a{rx!r} {ry!r} {rotation!r} {large:d} {sweep:d} {end.real!r} {end.imag!r}"
    ((arc,),) = shape_chains("path", Element("path", d=data))
    assert isinstance(arc, EllipticArc)
    assert_allclose(dense(arc, 2), [[1, 2], [1 + end.real, 2 + end.imag]], atol=1e-6)
    peer = Arc(1 + 2j, complex(rx, ry), rotation, large, sweep, 1 + 2j + end)
    # Nearly half ellipses are where its centre is off.
    tolerance = 1e-9 if abs(abs(peer.delta) - 180.0) > 1.0 else 1e-2
    expected = np.array([peer.point(t) for t in np.linspace(0, 1, 9)])
    assert_allclose(dense(arc, 9), np.column_stack([expected.real, expected.imag]), atol=tolerance)


def test_an_almost_half_circle_has_its_own_centre(tmp_path: Path) -> None:
    """svgpathtools puts the centre on the chord, which lifts the arc's top by 9 um."""
    (arc,) = segments(tmp_path, '<path d="M0 0A100.0000004 100.0000004 0 0 1 200 0"/>')
    assert_allclose(dense(arc, 2), [[0, 0], [0.2, 0]], atol=1e-12)
    radius = 0.1000000004
    assert_allclose(middle(arc), [0.1, radius - math.sqrt(radius**2 - 0.01)], atol=1e-12)


TRANSFORMS = {
    "translate(3)": np.array([[1, 0, 3], [0, 1, 0]]),
    "translate(3,4) scale(2)": np.array([[2, 0, 3], [0, 2, 4]]),
    "scale(1,-2)": np.array([[1, 0, 0], [0, -2, 0]]),
    "rotate(90)": np.array([[0, -1, 0], [1, 0, 0]]),
    "rotate(90 10 0)": np.array([[0, -1, 10], [1, 0, -10]]),
    "skewX(45)": np.array([[1, 1, 0], [0, 1, 0]]),
    "matrix(1 2 3 4 5 6)": np.array([[1, 3, 5], [2, 4, 6]]),
}


@pytest.mark.parametrize("text", TRANSFORMS)
def test_transforms_of_every_kind_of_segment(tmp_path: Path, text: str) -> None:
    data = "M1 2L5 2A5 3 20 0 1 9 6C10 8 12 8 13 6"
    plain = segments(tmp_path, f'<path d="{data}"/>')
    moved = segments(tmp_path, f'<g transform="{text}"><path d="{data}"/></g>')
    matrix = TRANSFORMS[text]
    for one, other in zip(plain, moved, strict=True):
        user = dense(one, 30) * [1e3, -1e3]
        expected = (user @ matrix[:, :2].T + matrix[:, 2]) * [1e-3, -1e-3]
        assert_allclose(dense(other, 30), expected, atol=1e-12)


def test_transforms_nest_from_the_outside_in(tmp_path: Path) -> None:
    body = '<g transform="translate(10)"><line transform="scale(2)" x1="1" x2="2"/></g>'
    (line,) = segments(tmp_path, body)
    assert_allclose(dense(line, 2), [[0.012, 0], [0.014, 0]])


def test_groups_give_feeds(tmp_path: Path) -> None:
    body = (
        '<g xmlns:i="http://www.inkscape.org/namespaces/inkscape" i:label="Cut" id="l1">'
        '<line x2="1"/><g id="slow"><line x1="1" x2="2"/></g></g><line x1="2" x2="3"/>'
    )
    feeds = replace(SETTINGS, layer_feeds_m_per_s={"CUT": 0.2, "slow": 0.1})
    path = load_tool_path(feeds, svg_file(tmp_path, body))
    assert path.feed_m_per_s.tolist() == [0.2, 0.1, SETTINGS.feed_m_per_s]


def test_what_draws_nothing_is_passed_over(tmp_path: Path) -> None:
    body = (
        "<defs><text>no</text><path d='M0 0'/></defs><title>t</title><style>line{fill:none}</style>"
        "<x:y xmlns:x='urn:editor'/><!-- c --><line x2='5'/>"
    )
    assert len(segments(tmp_path, body)) == 1


def test_plain_svg_without_a_namespace(tmp_path: Path) -> None:
    file = text_file(
        tmp_path, "a.svg", '<?xml version="1.0" encoding="UTF-8"?>\n<svg><line x2="1"/></svg>'
    )
    assert len(read_svg(file, SETTINGS)) == 1


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ("<text>hi</text>", "text 1 is not supported, expected one of path, line"),
        ("<use href='#a'/>", "use 1 is not supported"),
        ("<image id='x'/>", "image #x is not supported"),
        ("<svg><line x2='1'/></svg>", "svg 1 is not supported"),
        ("<circle r='0'/>", "circle 1 is with r 0, expected r above 0"),
        ("<circle r='nan'/>", 'circle 1 is with r="nan", expected a length'),
        ("<circle r='10%'/>", 'circle 1 is with r="10%"'),
        ("<rect width='5'/>", "rect 1 is with height 0"),
        ("<rect width='5' height='5' rx='-1'/>", "rect 1 is with a corner radius below 0"),
        ("<ellipse rx='1em' ry='2'/>", 'ellipse 1 is with rx="1em"'),
        ("<polyline points='0,0 1'/>", "polyline 1 is of 3 coordinates"),
        ("<polyline points='0,0 1,x'/>", 'polyline 1 is with points "0,0 1,x"'),
        ("<polygon/>", "polygon 1 is of 0 coordinates"),
        ("<path/>", "path 1 is without path data"),
        ("<path d='L 1 1'/>", 'path 1 is with path data that begins with "L"'),
        ("<path d='M0 0 L nan 1'/>", 'with "nan 1" in its path data'),
        ("<path d='M0 0 L 5'/>", "path 1 is with broken path data"),
        ("<path d='M0 0 A5 5 0 0 1 0 0'/>", "path 1 is with an arc that ends at its start"),
        ("<line x2='1' transform='rotate(1'/>", 'line 1 is with transform "rotate(1"'),
        ("<line x2='1' transform='twist(1)'/>", "a valid transform"),
        ("<line x2='1' transform='scale(0)'/>", "line 1 is flattened by its transform"),
        ("<line x2='1' style='display:none'/>", "line 1 is hidden (display: none)"),
        ("<g visibility='hidden'><line x2='1'/></g>", "g 1 is hidden"),
        ("<line x2='1' style='transform: scale(2)'/>", "line 1 is with transform in its style"),
        ("<style>.a{display:none}</style><line x2='1'/>", "style is a sheet that sets display"),
        ("<g>" * 150 + "<line x2='1'/>" + "</g>" * 150, "101 groups deep"),
    ],
)
def test_refused_elements(tmp_path: Path, body: str, says: str) -> None:
    with pytest.raises(InputError) as caught:
        segments(tmp_path, body)
    assert says in str(caught.value)
    assert "drawing.svg: " in str(caught.value)


@pytest.mark.parametrize(
    ("head", "says"),
    [
        ('width="10em" height="10"', 'svg width is "10em", expected a length above 0'),
        ('width="0" height="10"', 'svg width is "0"'),
        ('viewBox="0 0 0 10"', 'svg viewBox is "0 0 0 10", expected four numbers'),
        ('viewBox="0 0 10"', "svg viewBox"),
        ('viewBox="0 0 nan 10"', "svg viewBox"),
        ('width="10mm" height="10mm" viewBox="0 0 10 20"', "svg viewBox is stretched"),
        ('style="display:none"', "svg is hidden"),
    ],
)
def test_refused_sizes(tmp_path: Path, head: str, says: str) -> None:
    with pytest.raises(InputError) as caught:
        segments(tmp_path, '<line x2="1"/>', head)
    assert says in str(caught.value)
