"""CSV points."""

from __future__ import annotations

from pathlib import Path

import pytest
from drawings import SETTINGS, ends, text_file
from numpy.testing import assert_allclose

from servogen.errors import InputError
from servogen.paths.csv_points import read_csv
from servogen.paths.curves import Stroke
from servogen.paths.load import load_tool_path


def rows(folder: Path, text: str) -> list[Stroke]:
    return read_csv(text_file(folder, "points.csv", text), SETTINGS)


@pytest.mark.parametrize("header", ["", "x_m,y_m\n", "\ufeffx_m, y_m\n", "\n\nx_m,y_m\r\n"])
def test_points_in_metres_with_or_without_header(tmp_path: Path, header: str) -> None:
    (stroke,) = rows(tmp_path, header + "0.1,-2e-1\n\n 0.3 , 0\n")
    assert_allclose(ends(stroke), [[0.1, -0.2], [0.3, 0.0]])
    assert stroke.feed_m_per_s is None


def test_a_feed_is_that_of_the_move_to_its_row(tmp_path: Path) -> None:
    got = rows(tmp_path, "x_m,y_m,feed_m_per_s\n0,0,9\n1,0,0.2\n1,0,7\n1,1,0.1\n")
    assert [stroke.feed_m_per_s for stroke in got] == [0.2, 0.1]
    assert [stroke.label for stroke in got] == ["line 3", "line 5"]


def test_the_order_is_kept(tmp_path: Path) -> None:
    file = text_file(tmp_path, "p.csv", "0,0\n0.3,0\n0.1,0\n0.2,0.1\n")
    path = load_tool_path(SETTINGS, file)
    assert path.points.tolist() == [[0, 0], [0.3, 0], [0.1, 0], [0.2, 0.1]]


def test_a_header_names_a_z(tmp_path: Path) -> None:
    (stroke,) = rows(tmp_path, "x_m,y_m,z_m\n0,0,0\n0.1,0,-0.2\n")
    assert_allclose(ends(stroke), [[0, 0, 0], [0.1, 0, -0.2]])
    assert stroke.feed_m_per_s is None
    (stroke,) = rows(tmp_path, "x_m,y_m,z_m,feed_m_per_s\n0,0,0,1\n0,0,0.1,0.5\n")
    assert_allclose(ends(stroke)[1], [0, 0, 0.1])
    assert stroke.feed_m_per_s == 0.5


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("x,y\n0,0\n", 'line 1 is "x,y", expected the header x_m,y_m'),
        ("x_mm,y_mm\n0,0\n", "line 1 is"),
        ("0;0\n1;1\n", 'line 1 is "0;0"'),
        ("1\n2\n", "line 1 is"),
        ("0,0,1,4\n", "line 1 is"),
        ("0,0\n1,nan\n", 'line 2: y_m is "nan", expected a finite number'),
        ("0,0\n1e999,1\n", "line 2: x_m"),
        ("nan,0\n1,1\n", 'line 1: x_m is "nan"'),
        ("0,0\n\n1,one\n", 'line 3: y_m is "one"'),
        ("0,0\n1_0,1\n", 'line 2: x_m is "1_0"'),
        ("0,0\n1,\n", 'line 2: y_m is ""'),
        ("0,0\n1,1,1\n", "line 2 is of 3 columns, expected 2"),
        ("x_m,y_m,feed_m_per_s\n0,0\n", "line 2 is of 2 columns, expected 3"),
        ("x_m,y_m\nx_m,y_m\n", 'line 2: x_m is "x_m"'),
        ("0,0,1\n1,1,0\n", "line 2: feed_m_per_s is 0.0, expected a feed above 0"),
        (
            "0,0,1\n1,1,-2\n",
            "feed_m_per_s is -2.0, expected a feed above 0 (the header x_m,y_m,z_m",
        ),
        ("x_m,y_m,z_m\n0,0\n", "line 2 is of 2 columns, expected 3"),
        ("x_m,y_m,z_m\n0,0,0\n0,0,up\n", 'line 3: z_m is "up"'),
    ],
)
def test_refused_rows(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(InputError) as caught:
        rows(tmp_path, text)
    assert says in str(caught.value)
    assert "points.csv: line" in str(caught.value)
