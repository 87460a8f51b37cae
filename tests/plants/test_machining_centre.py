"""The axes of paper 2, with the signs that the print lost."""

from itertools import combinations

import numpy as np
import pytest

from servogen.plants.machining_centre import machining_centre


def velocity_gain(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    """m/s per unit of a constant input, once settled and before the integrator leaks."""
    state = np.zeros(len(b))
    seen = []
    for _ in range(60):
        state = a @ state + b
        seen.append(float(c @ state))
    return (seen[50] - seen[49]) / 0.0005


def modes(a: np.ndarray) -> np.ndarray:
    found = np.linalg.eigvals(a)
    return found[np.argsort(-found.real)]


def test_modes_and_gains_are_the_known_ones() -> None:
    x, y = machining_centre()
    assert modes(x.a)[0] == pytest.approx(0.99996, abs=1e-5)
    assert np.allclose(np.abs(modes(x.a)[1:]), abs(0.3487 + 0.529j), atol=1e-3)
    expected = [1.00004, 0.6423 + 0.4575j, 0.6423 - 0.4575j, 0.2230 + 0.7946j, 0.2230 - 0.7946j]
    assert all(np.min(np.abs(modes(y.a) - value)) < 1e-4 for value in expected)
    assert velocity_gain(x.a, x.b, x.c) == pytest.approx(0.022607, rel=0.005)
    assert velocity_gain(y.a, y.b, y.c) == pytest.approx(0.022338, rel=0.005)


def test_no_one_sign_and_no_other_two_bring_the_integrator_back() -> None:
    """As printed: neither sign; then every one and every two entries turned round."""
    printed = machining_centre()[1].a.copy()
    printed[2, 2], printed[3, 4] = -printed[2, 2], -printed[3, 4]
    assert np.max(np.abs(np.linalg.eigvals(printed))) > 1.05
    places = list(zip(*np.nonzero(printed), strict=True))
    fits = []
    for count in (1, 2):
        for chosen in combinations(places, count):
            a = printed.copy()
            for place in chosen:
                a[place] = -a[place]
            found = np.linalg.eigvals(a)
            if np.max(np.abs(found)) < 1.001 and np.min(np.abs(found - 1.0)) < 1e-3:
                fits.append(chosen)
    assert fits == [((2, 2), (3, 4))]
