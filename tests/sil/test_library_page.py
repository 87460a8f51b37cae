"""docs/library-explicit.md is a program: it runs as it stands, and its C is the reference's."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from servogen.controllers.design import Status
from servogen.controllers.lookup import Lookup
from servogen.qp.parametric_solver import ParametricSolver
from servogen.sil.build import built
from servogen.sil.compiled import CompiledController
from servogen.sil.edges import edge_calls
from servogen.sil.harness import compare
from servogen.sil.lookup_calls import lookup_calls

PAGE = Path(__file__).parents[2] / "docs" / "library-explicit.md"


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


@pytest.fixture(scope="module")
def page() -> dict[str, Any]:
    """What the page's program leaves behind."""
    names: dict[str, Any] = {}
    for block in blocks("python"):
        exec(block, names)
    return names


def test_two_inputs_in_a_box_are_looked_up_in_c_as_in_the_reference(page: dict[str, Any]) -> None:
    design = page["design"]
    assert (page["plant"].inputs, page["plant"].outputs, design.moves) == (2, 2, 2)
    assert page["problem"].qp.domain_bounds.size == 16
    declaration = Lookup(design).declaration
    calls = [*lookup_calls(design, np.random.default_rng(4), 500), *edge_calls(declaration)]
    with built(page["package"]) as module:
        agreement = compare(Lookup(design), CompiledController(module, declaration), calls)
    assert agreement.passed, agreement.difference
    assert agreement.worst == 0.0
    assert {"OK", "INFEASIBLE"} <= set(agreement.statuses)


def test_both_moves_are_the_program_s_all_over_the_box(page: dict[str, Any]) -> None:
    solver, lookup, reach = (
        ParametricSolver(page["problem"].qp),
        Lookup(page["design"]),
        page["reach"],
    )
    rng = np.random.default_rng(5)
    low, high = page["limits"].input.lower, page["limits"].input.upper
    limited = set()
    for _ in range(400):
        theta = (rng.uniform(-1.0, 1.0, 8) * reach * 10.0 ** rng.uniform(-2.0, 0.0)).astype("f4")
        status, out = lookup.call("find", {"theta": theta})
        assert status is Status.OK
        wanted = solver.solve(theta.astype(float)).z[:2]
        np.testing.assert_allclose(np.asarray(out["move"], float), wanted, atol=1e-4)
        limited.add(tuple(np.sign(wanted * (np.isclose(wanted, low) | np.isclose(wanted, high)))))
    assert len(limited) == 9  # each of the two at its lower bound, free, at its upper one


def test_the_c_on_the_page_compiles_and_gives_two_moves(
    page: dict[str, Any], tmp_path: Path
) -> None:
    for name, text in page["files"].items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    (shown,) = blocks("c")
    main = f'#include "pair_lookup.h"\nint main(void)\n{{\n{shown}return (int)out.move[1];\n}}\n'
    (tmp_path / "main.c").write_text(main)
    command = ["gcc", "-std=c99", "-Wall", "-Werror", "-I.", "main.c", "pair_lookup.c", "-lm"]
    subprocess.run([*command, "-o", "main"], cwd=tmp_path, check=True)
    assert subprocess.run([tmp_path / "main"], check=False).returncode == 0
