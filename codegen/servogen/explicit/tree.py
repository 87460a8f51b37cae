"""Binary search trees over first-move laws (Tondel, Johansen and Bemporad 2003): the tables."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from servogen.plants.statespace import read_only
from servogen.precision import FloatArray

NodeArray = npt.NDArray[np.int32]


@dataclass(frozen=True)
class Tree:
    """Inner node i: to ``children[i, 1]`` if normals[i] . eta > offsets[i], else to [i, 0].

    A child c >= 0 is an inner node, c < 0 is a leaf with law -1 - c. Node 0 is the root; a tree
    without inner nodes is the leaf ``root``.

    Attributes:
        normals: (inner, r), rows of unit length; offsets: (inner,).
        children: (inner, 2), int32.
        root: 0, or a negative leaf.
        mirror: coordinate of eta whose sign is tested first: below zero, eta is negated on the way
            in and the first move on the way out. -1 for none.
    """

    normals: FloatArray
    offsets: FloatArray
    children: NodeArray
    root: int
    mirror: int = -1

    def __post_init__(self) -> None:
        for name in ("normals", "offsets"):
            object.__setattr__(self, name, _frozen(getattr(self, name)))
        children = np.array(self.children, dtype=np.int32)
        children.flags.writeable = False
        object.__setattr__(self, "children", children)

    @property
    def inner(self) -> int:
        """Inner nodes."""
        return int(self.offsets.size)

    @property
    def leaves(self) -> int:
        """Leaves; several may hold one law."""
        return self.inner + 1

    @property
    def nodes(self) -> int:
        """Inner nodes and leaves."""
        return self.inner + self.leaves

    @property
    def depth(self) -> int:
        """Most inner nodes on a way from the root to a leaf; the mirror's test is not one."""
        depths = np.zeros(self.inner, dtype=np.int64)
        deepest = 0
        for i in range(self.inner):  # parents come before their children
            for child in self.children[i]:
                if child >= 0:
                    depths[child] = depths[i] + 1
            deepest = max(deepest, int(depths[i]) + 1)
        return deepest

    def rounded(self, dtype: npt.DTypeLike) -> Tree:
        """The same tree with its numbers rounded to ``dtype``, as the emitted tables hold them."""
        return Tree(
            self.normals.astype(dtype), self.offsets.astype(dtype), self.children, self.root,
            self.mirror,
        )  # fmt: skip


def _frozen(values: FloatArray) -> FloatArray:
    array: FloatArray = np.array(values, dtype=values.dtype if values.dtype.kind == "f" else None)
    array.flags.writeable = False
    return array


def descend(tree: Tree, eta: FloatArray) -> npt.NDArray[np.int64]:
    """(N,) the law that each of ``eta`` (N, r) reaches, in the arithmetic of eta's type.

    The sums run from the first coordinate to the last, each product rounded, each sum rounded: what
    C does without contraction. The mirror has been applied by the caller.
    """
    normals, offsets = tree.normals.astype(eta.dtype), tree.offsets.astype(eta.dtype)
    at = np.full(eta.shape[0], tree.root, dtype=np.int64)
    while np.any(at >= 0):
        live = np.flatnonzero(at >= 0)
        node = at[live]
        height = ordered_product(normals[node], eta[live])
        at[live] = tree.children[node, (height > offsets[node]).astype(np.int64)]
    return -1 - at


def ordered_product(rows: FloatArray, x: FloatArray) -> FloatArray:
    """(N,) row by row scalar products of two (N, r), from the first term to the last."""
    total: FloatArray = np.zeros(x.shape[0], dtype=x.dtype)
    for j in range(x.shape[1]):
        term = rows[:, j] * x[:, j]
        total = term if j == 0 else total + term
    return total


def empty_tree(size: int, law: int) -> Tree:
    """The leaf ``law`` on its own."""
    return Tree(
        read_only(np.zeros((0, size))), read_only(np.zeros(0)), np.zeros((0, 2), dtype=np.int32),
        -1 - law,
    )  # fmt: skip
