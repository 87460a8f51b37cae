"""docs/library-qp.md is a program: it runs as it stands, and its C is the reference's."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path
from typing import Any

import daqp
import numpy as np
import pytest

from servogen.controllers.design import Status
from servogen.controllers.qp_solver import QpSolver
from servogen.sil.build import built
from servogen.sil.compiled import CompiledController
from servogen.sil.edges import edge_calls
from servogen.sil.harness import Call, compare

PAGE = Path(__file__).parents[2] / "docs" / "library-qp.md"


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


@pytest.fixture(scope="module")
def page() -> dict[str, Any]:
    """What the page's program leaves behind."""
    names: dict[str, Any] = {}
    for block in blocks("python"):
        exec(block, names)
    return names


def test_the_answer_on_the_page_is_daqps(page: dict[str, Any]) -> None:
    assert page["status"] is Status.OK
    rows = np.vstack([np.eye(3), [[1.0, 1.0, 1.0]]])
    high, low = np.array([1.0, 1.0, 1.0, 1.5]), np.array([-1.0, -1.0, -1.0, -1e30])
    hessian = np.array([[2.0, 0.5, 0.0], [0.5, 1.0, 0.2], [0.0, 0.2, 1.5]])
    linear = np.array([-4.0, 1.0, -3.0])
    z = daqp.solve(hessian, linear, rows, high, low, np.zeros(4, dtype=np.int32))[0]
    np.testing.assert_allclose(page["out"]["z"], z, atol=1e-8)
    assert np.count_nonzero(np.isclose(rows @ z, high)) >= 2  # bounds of variables and the sum act


@pytest.mark.parametrize("name", ["design", "moving"])
def test_the_c_is_the_reference(page: dict[str, Any], name: str) -> None:
    package = page["package" if name == "design" else "moving_package"]
    reference = QpSolver(page[name])
    (linear, low, _) = (port.size for port in reference.declaration.operation("step").inputs)
    assert linear is not None
    assert low is not None
    rng = np.random.default_rng(3)
    calls = [Call("reset", {})]
    for _ in range(200):
        reach = 10.0 ** rng.uniform(-1.0, 1.0)
        given = {"linear": reach * rng.normal(size=linear), "low": -rng.uniform(0.1, 1.0, low)}
        calls.append(Call("step", {**given, "high": rng.uniform(0.1, 1.0, low)}))
    calls += edge_calls(reference.declaration)
    with built(package) as module:
        agreement = compare(reference, CompiledController(module, reference.declaration), calls)
    assert agreement.passed, agreement.difference
    assert agreement.worst == 0.0
    assert "OK" in agreement.statuses


def test_the_plant_on_the_page_has_the_rows_that_it_says(page: dict[str, Any]) -> None:
    """u_k, x_k, v_k: a push in the first step, and how far it has carried the cart."""
    effect = page["effect"]
    np.testing.assert_allclose(effect[:6, 0], [1.0, 0.005, 0.1, 0.0, 0.015, 0.1])


def test_the_certificate_on_the_page_is_exact(page: dict[str, Any]) -> None:
    found = page["found"]
    assert found.exact
    assert found.bound >= 3


def test_the_c_on_the_page_compiles_and_is_right(page: dict[str, Any], tmp_path: Path) -> None:
    for name, text in page["files"].items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    (shown,) = blocks("c")
    wanted = float(page["out"]["z"][0])
    main = (
        f'#include "allot.h"\nint main(void)\n{{\n{shown}'
        f"return (out.z[0] == {wanted!r}) ? 0 : 1;\n}}\n"
    )
    (tmp_path / "main.c").write_text(main)
    command = ["gcc", "-std=c99", "-ffp-contract=off", "-Wall", "-Werror", "-I.", "main.c"]
    subprocess.run([*command, "allot.c", "-o", "main"], cwd=tmp_path, check=True)
    assert subprocess.run([tmp_path / "main"], check=False).returncode == 0
