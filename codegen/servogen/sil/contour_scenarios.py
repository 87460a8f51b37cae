"""What is tried on the contour controller, besides its closed loop."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from servogen.controllers.contour_lq import ContourLq
from servogen.controllers.contour_lq_design import ContourLqDesign
from servogen.controllers.design import Reference
from servogen.sil.contour_calls import arriving_calls, contour_calls
from servogen.sil.edges import edge_calls
from servogen.sil.scenarios import Scenario


def contour_suite(design: ContourLqDesign, seed: int, count: int) -> Iterator[Scenario]:
    """Edges, a motion that begins and ends, and ``count`` random samples. The same seed gives the
    same scenarios."""

    def factory() -> Reference:
        return ContourLq(design)

    edges = list(edge_calls(factory().declaration))
    yield Scenario(f"{design.prefix}: edges", factory, edges)
    yield Scenario(f"{design.prefix}: arriving", factory, list(arriving_calls(design)))
    calls = list(contour_calls(design, np.random.default_rng(seed), count))
    yield Scenario(f"{design.prefix}: random", factory, calls)
