"""Bad drawings: one sentence with the file and the place, and never another exception."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import ezdxf
import pytest
from drawings import SETTINGS, dxf_file

from servogen.errors import InputError
from servogen.paths.load import load_tool_path

SAMPLES = Path(__file__).parent / "samples"
HEADER = "0 SECTION 2 HEADER 9 $ACADVER 1 AC1015 9 $INSUNITS 70 4 0 ENDSEC 0 SECTION 2 ENTITIES "
ELLIPSE = "0 ELLIPSE 8 0 10 0.0 20 0.0 11 {} 21 0.0 40 {} 41 0.0 42 6.0"


@dataclass(frozen=True)
class Bad:
    """A drawing by its file's name and content, and what must be said of it."""

    what: str
    name: str
    content: str | bytes | Callable[[Any], None]
    says: tuple[str, ...]


def dxf(body: str, head: str = HEADER) -> str:
    """DXF tags from words."""
    return "\n".join(f"{head}{body} 0 ENDSEC 0 EOF".split()) + "\n"


def svg(body: str) -> str:
    return f'<svg xmlns="http://www.w3.org/2000/svg">{body}</svg>'


def space(method: str, *arguments: Any, **keywords: Any) -> Callable[[Any], None]:
    """A drawing of one entity, added to the model space by a method of ezdxf."""

    def draw(document: Any) -> None:
        getattr(document.modelspace(), method)(*arguments, **keywords)

    return draw


def looping_blocks(document: Any) -> None:
    for name, other in (("A", "B"), ("B", "A")):
        document.blocks.new(name).add_blockref(other, (0, 0))
    document.modelspace().add_blockref("A", (0, 0))


def many_copies(document: Any) -> None:
    document.blocks.new("A").add_line((0, 0), (1, 0))
    grid = {"column_count": 30_000, "row_count": 30_000, "column_spacing": 1, "row_spacing": 1}
    document.modelspace().add_blockref("A", (0, 0), dxfattribs=grid)


def block_bomb(document: Any) -> None:
    """Nothing in the end, ten billion times."""
    document.blocks.new("B0")
    for level in range(1, 11):
        block = document.blocks.new(f"B{level}")
        for k in range(10):
            block.add_blockref(f"B{level - 1}", (k, 0))
    document.modelspace().add_blockref("B10", (0, 0))


def bad_knots(document: Any) -> None:
    spline = document.modelspace().add_open_spline([(0, 0), (1, 1), (2, 0), (3, 1)])
    spline.knots = [0, 0, 0, 0, 3, 2, 1, 1]


def bad_weights(document: Any) -> None:
    control = [(0, 0), (1, 1), (2, 0), (3, 1)]
    document.modelspace().add_rational_spline(control, [1, 0, -1, 1])


def text_in_a_block(document: Any) -> None:
    document.blocks.new("NOTE").add_text("no")
    document.modelspace().add_blockref("NOTE", (0, 0))


COMMON = [
    Bad(f"{what} {suffix}", f"a{suffix}", content, says)
    for suffix in (".dxf", ".svg", ".nc", ".gcode", ".ngc", ".csv")
    for what, content, says in (
        ("empty", "", ("drawing is empty",)),
        ("blank", " \n\n\t\n", ("drawing is empty",)),
        ("binary", bytes(range(256)) * 20, ()),
        ("UTF-16", "0,0\n1,1\n".encode("utf-16"), ()),
        ("picture", b"\x89PNG\r\n\x1a\n" + bytes(100), ()),
        ("web page", "<html><body><p>404</p></body></html>", ()),
    )
]
DXF = [
    Bad("no entities", "a.dxf", dxf(""), ("drawing, expected at least one line or curve",)),
    Bad("cut off", "a.dxf", dxf("0 LINE 8 0 10 0.0 20 0.0 11 1.0 21")[:-20], ("broken",)),
    Bad(
        "unknown unit", "a.dxf", dxf("0 LINE", HEADER.replace("70 4", "70 3")), ("$INSUNITS is 3",)
    ),
    Bad("text for a number", "a.dxf", dxf("0 LINE 8 0 10 x 20 0.0"), ("broken",)),
    Bad("line without an end", "a.dxf", dxf("0 LINE 8 0 10 0.0 20 1.0"), ("LINE", "its end")),
    Bad("circle without a radius", "a.dxf", dxf("0 CIRCLE 8 0 10 1.0 20 1.0"), ("its radius",)),
    Bad("NaN", "a.dxf", dxf("0 LINE 8 0 10 nan 20 0.0 11 1.0 21 1.0"), ("LINE", "finite")),
    Bad(
        "infinite angle", "a.dxf", space("add_arc", (0, 0), 1, float("inf"), 3), ("ARC #", "broken")
    ),
    Bad("zero length", "a.dxf", space("add_line", (1, 1), (1, 1)), ("LINE #", "of length zero")),
    Bad("huge place", "a.dxf", space("add_line", (0, 0), (1e12, 0)), ("1e+09 m from the origin",)),
    Bad("huge circle", "a.dxf", space("add_circle", (0, 0), 1e300), ("CIRCLE #", "1000 m")),
    Bad("radius below 0", "a.dxf", space("add_circle", (0, 0), -1), ("CIRCLE #", "of radius -1")),
    Bad("one vertex", "a.dxf", space("add_lwpolyline", [(0, 0)]), ("a polyline of 1 vertices",)),
    Bad("one place", "a.dxf", space("add_lwpolyline", [(1, 1), (1, 1)]), ("of length zero",)),
    Bad(
        "bulge NaN",
        "a.dxf",
        space("add_lwpolyline", [(0, 0, float("nan")), (1, 1, 0)], format="xyb"),
        ("LWPOLYLINE #",),
    ),
    Bad(
        "bulge out of all proportion",
        "a.dxf",
        space("add_lwpolyline", [(0, 0, 1e200), (1, 1, 0)], format="xyb"),
        ("LWPOLYLINE #",),
    ),
    Bad("ellipse of ratio NaN", "a.dxf", dxf(ELLIPSE.format(5, "nan")), ("of axis ratio nan",)),
    Bad("ellipse of no size", "a.dxf", dxf(ELLIPSE.format(0, 0.5)), ("ELLIPSE #", "broken")),
    Bad("knots that go back", "a.dxf", bad_knots, ("SPLINE #",)),
    Bad("weights below 0", "a.dxf", bad_weights, ("SPLINE #", "weight")),
    Bad("spline without points", "a.dxf", space("add_spline"), ("SPLINE #",)),
    Bad("writing", "a.dxf", space("add_text", "hello"), ("TEXT #", "not supported, expected LINE")),
    Bad("hatch", "a.dxf", space("add_hatch"), ("HATCH #", "not supported")),
    Bad("point", "a.dxf", space("add_point", (0, 0)), ("POINT #", "not supported")),
    Bad("mesh", "a.dxf", space("add_polymesh", (3, 3)), ("POLYLINE #", "a mesh")),
    Bad("not flat", "a.dxf", space("add_line", (0, 0, 0), (1, 0, 1)), ("LINE #", "not flat")),
    Bad(
        "tilted",
        "a.dxf",
        space("add_circle", (0, 0), 1, dxfattribs={"extrusion": (1, 0, 0)}),
        ("CIRCLE #", "tilted out of the plane"),
    ),
    Bad("block missing", "a.dxf", space("add_blockref", "NONE", (0, 0)), ("missing block NONE",)),
    Bad("blocks in a loop", "a.dxf", looping_blocks, ("of block A within itself",)),
    Bad("copies without end", "a.dxf", many_copies, ("900000000 copies of blocks",)),
    Bad("blocks of blocks of blocks", "a.dxf", block_bomb, ("copies of blocks, ",)),
    Bad("writing in a block", "a.dxf", text_in_a_block, ("TEXT #", "not supported")),
]
SVG = [
    Bad("no shapes", "a.svg", svg("<title>t</title>"), ("drawing, expected at least one line",)),
    Bad("cut off", "a.svg", svg("<line x2='1'/>")[:-5], ("line 1 is broken",)),
    Bad("two roots", "a.svg", svg("") * 2, ("line 1 is broken (junk",)),
    Bad("zero length", "a.svg", svg("<line/>"), ("line 1 is of length zero",)),
    Bad("huge", "a.svg", svg("<line x2='1e30'/>"), ("line 1 is", "from the origin")),
    Bad("overflow", "a.svg", svg("<path d='M0 0L1e999 0'/>"), ("path 1, expected finite",)),
    Bad(
        "entities without end",
        "a.svg",
        "<!DOCTYPE svg [<!ENTITY a '"
        + "x" * 50
        + "'>"
        + "".join(
            f"<!ENTITY {b} '{f'&{a};' * 10}'>" for a, b in zip("abcdefgh", "bcdefghi", strict=True)
        )
        + "]><svg><title>&i;</title></svg>",
        ("line 1 is broken",),
    ),
]
GCODE = [
    Bad("no moves", "a.nc", "%\nG21\nM30\n%\n", ("drawing, expected at least one line or curve",)),
    Bad("only to and fro", "a.nc", "G0 X1\nG0 X2\n", ("drawing, expected at least one",)),
    Bad("another plane", "a.gcode", "G18\nG1 X1\n", ("line 1 is G18",)),
    Bad("dwell", "a.nc", "G1 X1\nG4 P1\n", ("line 2 is P1",)),
    Bad("arc apart", "a.ngc", "G2 X10 I3\n", ("line 1 is an arc of radius 3 mm at its start",)),
    Bad("overflow", "a.nc", "G1 X99999999999999\n", ("line 1 is 1e+11 m from the origin",)),
    Bad(
        "z",
        "a.nc",
        "G1 X1\nG0 Z5\nG0 X0\n",
        ("line 2 is a move of z to 0.005 m, expected a level",),
    ),
    Bad("helix", "a.nc", "G2 I1 Z2\n", ("line 1 is a move of z", "there are two axes")),
    Bad("line 1,000", "a.nc", "G1 X1\n" * 999 + "G1 Q1\n", ("line 1000 is Q1",)),
]
CSV = [
    Bad(
        "header only", "a.csv", "x_m,y_m\n", ("drawing is without a point, expected points at two",)
    ),
    Bad("one point", "a.csv", "1,1\n", ("drawing is a single point, expected points at two",)),
    Bad("one place", "a.csv", "1,1\n1,1\n", ("drawing is a single point",)),
    Bad("millimetres", "a.csv", "0,0\n2000,0\n", ("line 2 is 2000 m from the origin",)),
    Bad("z in rows", "a.csv", "x_m,y_m,z_m\n0,0,0\n1,1,1\n", ("line 3 is a move of z to 1 m",)),
    Bad("ragged", "a.csv", "0,0\n1\n", ("line 2 is of 1 column, expected 2",)),
    Bad("wrong byte", "a.csv", b"0,0\n1,\xff\n", ("line 2 is not UTF-8 (byte 0xff)",)),
    Bad("byte of 0", "a.csv", "0,0\n1,\0\n", ("line 2 is binary",)),
]
ALL = [*COMMON, *DXF, *SVG, *GCODE, *CSV]


def written(bad: Bad, folder: Path) -> Path:
    file = folder / bad.name
    if callable(bad.content):
        return dxf_file(folder, bad.content)
    file.write_bytes(bad.content.encode() if isinstance(bad.content, str) else bad.content)
    return file


@pytest.mark.parametrize("bad", ALL, ids=[f"{bad.what} {bad.name}" for bad in ALL])
def test_bad_drawing(bad: Bad, tmp_path: Path) -> None:
    file = written(bad, tmp_path)
    with pytest.raises(InputError) as caught:
        load_tool_path(SETTINGS, file)
    message = str(caught.value)
    assert caught.value.file == str(file)
    assert message.startswith(f"{file}: ")
    assert ", expected " in message
    assert "\n" not in message
    assert len(message) < 400 + len(str(file))
    for fragment in bad.says:
        assert fragment in message


def test_heights_are_dropped_or_added_where_they_say_nothing(tmp_path: Path) -> None:
    file = tmp_path / "a.nc"
    file.write_text("G0 Z5\nG1 X1\nG1 Y1 Z5\n", encoding="utf-8")
    assert load_tool_path(SETTINGS, file).points.shape == (3, 2)
    assert load_tool_path(SETTINGS, file, 3).points[:, 2].tolist() == [0.005] * 3
    file.write_text("G1 X1\nG1 Y1\n", encoding="utf-8")
    assert load_tool_path(SETTINGS, file, 3).points[:, 2].tolist() == [0.0] * 3


def test_there_are_many_kinds() -> None:
    assert len(DXF) + len(SVG) + len(GCODE) + len(CSV) >= 45


def test_no_file(tmp_path: Path) -> None:
    for suffix in (".dxf", ".svg", ".nc", ".csv"):
        with pytest.raises(InputError, match=r"drawing is unreadable, expected .*No such file"):
            load_tool_path(SETTINGS, tmp_path / f"none{suffix}")
        folder = tmp_path / f"folder{suffix}"
        folder.mkdir()
        with pytest.raises(InputError, match="drawing is unreadable"):
            load_tool_path(SETTINGS, folder)


def test_another_kind_of_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"path.file is a .pdf file, expected one of .csv, .dxf"):
        load_tool_path(SETTINGS, tmp_path / "a.pdf")


def test_layer_feeds_that_no_layer_has(tmp_path: Path) -> None:
    settings = SETTINGS.__class__(layer_feeds_m_per_s={"CUT": 0.1})
    good = dxf_file(tmp_path, space("add_line", (0, 0), (1, 0)))
    for file in (good, SAMPLES / "plate.svg", SAMPLES / "plate.nc", SAMPLES / "plate.csv"):
        with pytest.raises(InputError, match=r"path.layer_feeds_m_per_s.CUT"):
            load_tool_path(settings, file)


@pytest.mark.parametrize("name", ["plate.svg", "plate.nc", "plate.csv", "plate.dxf"])
def test_damaged_files_never_surprise(name: str, tmp_path: Path) -> None:
    """Cut off, or with bytes changed, a good file is read or refused, and nothing else."""
    if name == "plate.dxf":
        document = ezdxf.new("R2000", units=4)
        document.modelspace().add_lwpolyline([(0, 0, 0.5), (10, 0, 0), (10, 10, 0)], format="xyb")
        document.modelspace().add_open_spline([(0, 0), (3, 8), (6, -4), (12, 5)])
        document.modelspace().add_ellipse((0, 0), (5, 0), 0.5)
        document.saveas(tmp_path / "good.dxf")
        text = (tmp_path / "good.dxf").read_bytes()
        good = text[text.index(b"ENTITIES") - 40 :]
        good = b"  0\nSECTION\n" + good[good.index(b"  2\nENTITIES") :]
        good = good[: good.index(b"ENDSEC")] + b"ENDSEC\n  0\nEOF\n"
    else:
        good = (SAMPLES / name).read_bytes()
    source = random.Random(5)
    file = tmp_path / name
    refused = 0
    for trial in range(150):
        data = bytearray(good)
        if trial % 3 == 0:
            data = data[: source.randrange(len(data))]
        for _ in range(trial % 3):
            data[source.randrange(len(data))] = source.choice(b'0123456789.-eXG<>" \n\xff\x00')
        file.write_bytes(bytes(data))
        error = what_is_said(file)
        assert error is None or error.file == str(file)
        refused += error is not None
    assert 20 < refused < 150


def what_is_said(file: Path) -> InputError | None:
    try:
        load_tool_path(SETTINGS, file)
    except InputError as error:
        return error
    return None
