"""Solutions in other coordinates are the same solutions, and their half trees are smaller."""

import numpy as np
import pytest
from explicit_problems import double_integrator, servo_drive

from servogen.explicit.choose import choose
from servogen.explicit.clips import without_first_bounds
from servogen.explicit.explore import solve
from servogen.explicit.grow import Growth, is_odd
from servogen.explicit.lookup import tree_lookup
from servogen.explicit.pieces import arrange
from servogen.explicit.prove import prove_tree
from servogen.explicit.turned import turned

PROGRAMS = {
    "clips": without_first_bounds(servo_drive(3))[0],
    "laws": servo_drive(3),
    "box": servo_drive(2, inside_box=True),
    "states": double_integrator(5),
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_they_give_the_same_moves_and_proved_trees(name: str) -> None:
    solution = solve(PROGRAMS[name], 500)
    plane = arrange(solution).planes[-1, :-1]
    other, at = turned(solution, plane / np.linalg.norm(plane))
    assert is_odd(other)
    theta = np.random.default_rng(3).normal(size=(500, solution.problem.parameters))
    theta = theta * (1.0 if name == "states" else 0.02)
    np.testing.assert_allclose(other.first_move(theta), solution.first_move(theta), atol=1e-8)
    for region in other.regions:
        assert 0.0 < region.radius <= np.min(region.k - region.h @ region.centre, initial=1.0)
    growth = Growth(arrange(other), at)
    growth.lower(200)
    proof = prove_tree(growth.tree(), other)
    assert proof.holds()
    assert proof.unreached == 0
    found = tree_lookup(other, growth.tree()).evaluate(theta)
    wanted = solution.first_move(theta)
    inside = ~np.isnan(wanted)
    assert np.mean(inside) > 0.1
    np.testing.assert_allclose(found[inside], wanted[inside], atol=1e-8)


def test_a_clip_tree_of_the_servo_has_fifteen_nodes() -> None:
    """Of the half on one side of the middle between two parallel facets."""
    solution = solve(PROGRAMS["clips"], 100)
    normal = arrange(solution).planes[4, :-1]
    other, at = turned(solution, normal / np.linalg.norm(normal))
    growth = Growth(arrange(other), at)
    growth.lower(500)
    assert (growth.tree().nodes, growth.tree().depth) == (15, 3)
    names = [form.name for form in choose(servo_drive(3), 100).forms]
    assert "clip tree, odd across hyperplane 4" in names
