"""DXF: units, entities, blocks, layers."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from drawings import SETTINGS, dense, dxf_file, ends, middle
from numpy.testing import assert_allclose

from servogen.errors import InputError
from servogen.paths.curves import EllipticArc, Line
from servogen.paths.dxf import read_dxf
from servogen.paths.load import load_tool_path


@pytest.mark.parametrize(
    ("units", "metres"), [(0, 1e-3), (1, 0.0254), (4, 1e-3), (5, 1e-2), (6, 1.0), (13, 1e-6)]
)
def test_units_of_the_header(tmp_path: Path, units: int, metres: float) -> None:
    file = dxf_file(tmp_path, lambda d: d.modelspace().add_line((1, 2), (3, -4)), units)
    (stroke,) = read_dxf(file, SETTINGS)
    assert_allclose(ends(stroke), metres * np.array([[1, 2], [3, -4]]), rtol=1e-15)


def test_no_header_means_millimetres(tmp_path: Path) -> None:
    file = tmp_path / "bare.dxf"
    text = "0 SECTION 2 ENTITIES 0 LINE 8 0 10 0.0 20 0.0 11 7.0 21 0.0 0 ENDSEC 0 EOF"
    file.write_text("\n".join(text.split()) + "\n")
    (stroke,) = read_dxf(file, SETTINGS)
    assert_allclose(ends(stroke)[1], [7e-3, 0.0])


@pytest.mark.parametrize("bulge", [0.5, -0.5, 1.0, -1.0, 2.5])
def test_bulge_sign_and_size(tmp_path: Path, bulge: float) -> None:
    """A bulge above 0 runs counter-clockwise: from (0,0) to (10,0) it sags to y below 0."""
    rows = [(0, 0, bulge), (10, 0, 0)]
    file = dxf_file(tmp_path, lambda d: d.modelspace().add_lwpolyline(rows, format="xyb"))
    ((arc,),) = (stroke.segments for stroke in read_dxf(file, SETTINGS))
    assert isinstance(arc, EllipticArc)
    assert_allclose(middle(arc), [5e-3, -bulge * 5e-3], atol=1e-15)
    assert_allclose(dense(arc, 2), [[0, 0], [10e-3, 0]], atol=1e-15)
    assert arc.t1 - arc.t0 == pytest.approx(4.0 * math.atan(bulge))


def test_a_bulge_next_to_nothing_is_a_line(tmp_path: Path) -> None:
    rows = [(0, 0, 1e-12), (10, 0, 0)]
    file = dxf_file(tmp_path, lambda d: d.modelspace().add_lwpolyline(rows, format="xyb"))
    assert read_dxf(file, SETTINGS)[0].segments == (Line((0.0, 0.0), (0.01, 0.0)),)


def test_closed_polylines_close_and_repeated_vertices_vanish(tmp_path: Path) -> None:
    rows = [(0, 0), (10, 0), (10, 0), (10, 10)]

    def draw(document: Any) -> None:
        document.modelspace().add_lwpolyline(rows, close=True)
        document.modelspace().add_polyline2d(rows, close=True)

    for stroke in read_dxf(dxf_file(tmp_path, draw), SETTINGS):
        assert len(stroke.segments) == 3
        assert_allclose(ends(stroke), np.zeros((2, 2)))


def test_arc_across_zero_degrees(tmp_path: Path) -> None:
    file = dxf_file(tmp_path, lambda d: d.modelspace().add_arc((1, 1), 2, 350, 10))
    ((arc,),) = (stroke.segments for stroke in read_dxf(file, SETTINGS))
    assert_allclose(middle(arc), [3e-3, 1e-3], atol=1e-15)
    assert arc.t1 - arc.t0 == pytest.approx(math.radians(20.0))


def test_an_entity_seen_from_below_is_mirrored(tmp_path: Path) -> None:
    def draw(document: Any) -> None:
        space, below = document.modelspace(), {"extrusion": (0, 0, -1)}
        space.add_arc((1, 1), 2, 0, 90, dxfattribs=below)
        space.add_lwpolyline([(0, 0, 1), (10, 0, 0)], format="xyb", dxfattribs=below)

    arc, polyline = read_dxf(dxf_file(tmp_path, draw), SETTINGS)
    assert_allclose(ends(arc), [[-3e-3, 1e-3], [-1e-3, 3e-3]], atol=1e-15)
    assert_allclose(middle(polyline.segments[0]), [-5e-3, -5e-3], atol=1e-15)


def test_ellipse(tmp_path: Path) -> None:
    def draw(document: Any) -> None:
        document.modelspace().add_ellipse((1, 2), (0, 4), 0.5, 0.0, math.pi / 2)

    ((arc,),) = (stroke.segments for stroke in read_dxf(dxf_file(tmp_path, draw), SETTINGS))
    assert_allclose(dense(arc, 2), [[1e-3, 6e-3], [-1e-3, 2e-3]], atol=1e-15)


def test_spline_against_ezdxf(tmp_path: Path) -> None:
    control = [(0, 0), (3, 8), (6, -4), (12, 5), (15, 0), (20, 3)]
    weights = [1, 2, 1, 0.5, 1, 1]
    made: list[Any] = []

    def draw(document: Any) -> None:
        space = document.modelspace()
        made.append(space.add_open_spline(control))
        made.append(space.add_rational_spline(control, weights))

    strokes = read_dxf(dxf_file(tmp_path, draw), SETTINGS)
    for spline, stroke in zip(made, strokes, strict=True):
        (curve,) = stroke.segments
        tool = spline.construction_tool()
        parameters = np.linspace(curve.breaks[0], curve.breaks[-1], 50)
        expected = [(p.x, p.y) for p in tool.points(parameters.tolist())]
        assert_allclose(curve.sample(parameters).points, 1e-3 * np.array(expected), atol=1e-14)


def test_spline_through_fit_points(tmp_path: Path) -> None:
    through = [(0, 0), (5, 5), (10, 0), (15, 5)]
    file = dxf_file(tmp_path, lambda d: d.modelspace().add_spline(through))
    ((curve,),) = (stroke.segments for stroke in read_dxf(file, SETTINGS))
    for point in through:
        gap = np.hypot(*(dense(curve) - 1e-3 * np.array(point)).T)
        assert gap.min() < 2e-6


def test_blocks_are_exploded_in_place(tmp_path: Path) -> None:
    """Twice as wide as high, turned by 90 degrees: the circle becomes an upright ellipse."""

    def draw(document: Any) -> None:
        block = document.blocks.new("PART")
        block.add_circle((0, 0), 5)
        place = {"xscale": 2, "yscale": 1, "rotation": 90}
        document.modelspace().add_blockref("PART", (100, 50), dxfattribs=place)

    (stroke,) = read_dxf(dxf_file(tmp_path, draw), SETTINGS)
    assert stroke.label.startswith("ELLIPSE #")
    points = dense(stroke.segments[0])
    assert_allclose(points.max(axis=0) - points.min(axis=0), [10e-3, 20e-3], rtol=1e-6)
    assert_allclose(points.mean(axis=0), [0.1, 0.05], atol=1e-5)


def test_a_block_in_rows_and_columns(tmp_path: Path) -> None:
    def draw(document: Any) -> None:
        document.blocks.new("DASH").add_line((0, 0), (1, 0))
        grid = {"column_count": 3, "row_count": 2, "column_spacing": 10, "row_spacing": 20}
        document.modelspace().add_blockref("DASH", (0, 0), dxfattribs=grid)

    starts = {
        tuple(ends(stroke)[0].round(9)) for stroke in read_dxf(dxf_file(tmp_path, draw), SETTINGS)
    }
    assert starts == {(x, y) for x in (0.0, 0.01, 0.02) for y in (0.0, 0.02)}


def test_layers_give_feeds_whatever_their_case(tmp_path: Path) -> None:
    def draw(document: Any) -> None:
        space = document.modelspace()
        space.add_line((0, 0), (1, 0), dxfattribs={"layer": "CUT"})
        space.add_line((1, 0), (2, 0))
        document.blocks.new("B").add_line((0, 0), (1, 0))  # on layer 0: takes the INSERT's
        space.add_blockref("B", (2, 0), dxfattribs={"layer": "CUT"})

    settings = replace(SETTINGS, layer_feeds_m_per_s={"cut": 0.05})
    path = load_tool_path(settings, dxf_file(tmp_path, draw))
    assert path.feed_m_per_s.tolist() == [0.05, SETTINGS.feed_m_per_s, 0.05]


def test_paper_space_is_not_read(tmp_path: Path) -> None:
    def draw(document: Any) -> None:
        document.modelspace().add_line((0, 0), (1, 0))
        document.layout("Layout1").add_text("sheet 1")

    assert len(read_dxf(dxf_file(tmp_path, draw), SETTINGS)) == 1


@pytest.mark.parametrize("hide", ["off", "freeze", "invisible"])
def test_hidden_entities_are_refused(tmp_path: Path, hide: str) -> None:
    def draw(document: Any) -> None:
        layer = document.layers.add("AUX")
        line = document.modelspace().add_line((0, 0), (1, 0), dxfattribs={"layer": "AUX"})
        if hide == "invisible":
            line.dxf.invisible = 1
        else:
            getattr(layer, hide)()

    with pytest.raises(InputError, match=r"hidden layer AUX|is invisible"):
        read_dxf(dxf_file(tmp_path, draw), SETTINGS)
