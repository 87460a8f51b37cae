"""A solution in coordinates of which one measures across a given hyperplane.

An odd program needs a tree for half of its parameters alone. Which half decides how many regions
the tree has to tell apart; whether a parameter is in it is one comparison if the half ends where a
coordinate is zero. So a coordinate is exchanged for another: nothing else of a lookup changes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servogen.explicit.image import Image
from servogen.explicit.regions import Region
from servogen.explicit.solution import ExplicitSolution, Laws
from servogen.plants.statespace import FloatArray, read_only


def turned(solution: ExplicitSolution, direction: FloatArray) -> tuple[ExplicitSolution, int]:
    """The same solution with direction . eta for the coordinate that it is nearest to, and which
    that is.

    Args:
        direction: (r,) of unit length.
    """
    program, image = solution.program, solution.image
    at = int(np.argmax(np.abs(direction)))
    forth = np.eye(image.size)
    forth[at] = direction
    back: FloatArray = np.linalg.inv(forth).astype(np.float64)
    rows, bounds = _unit(program.domain_rows @ back, program.domain_bounds)
    moved = replace(
        program,
        e=program.e @ back,
        base=program.base @ back,
        domain_rows=rows,
        domain_bounds=bounds,
        image=Image(forth @ image.matrix, forth @ image.offset),
        box_optimum=False,
    )
    laws = Laws(read_only(solution.laws.gains @ back), solution.laws.offsets)
    regions = tuple(_region(region, forth, back) for region in solution.regions)
    return replace(solution, program=moved, regions=regions, laws=laws), at


def _region(region: Region, forth: FloatArray, back: FloatArray) -> Region:
    h, k = _unit(region.h @ back, region.k)
    centre = forth @ region.centre
    return replace(
        region,
        h=read_only(h),
        k=read_only(k),
        slope=read_only(region.slope @ back),
        centre=read_only(centre),
        radius=float(np.min(k - h @ centre, initial=1.0)),
    )


def _unit(rows: FloatArray, bounds: FloatArray) -> tuple[FloatArray, FloatArray]:
    lengths = np.linalg.norm(rows, axis=1)
    unit: FloatArray = rows / lengths[:, None]
    heights: FloatArray = bounds / lengths
    return unit, heights
