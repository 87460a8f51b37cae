"""A lookup's tables as they stand in the emitted C, read back."""

from __future__ import annotations

import re

import numpy as np

from servogen.emit.package import CPackage
from servogen.explicit.tree import Tree

_TABLE = re.compile(r"static const (\w+) (\w+)\[\d+\] = \{([^}]*)\};")


def tables(package: CPackage, prefix: str) -> dict[str, np.ndarray]:
    """Every table of a controller by name, flat, in the type that the C gives it."""
    text = package.files[f"{prefix}_tables.h"]
    real = np.dtype(package.declarations[0].precision.name)
    found = {}
    for kind, name, body in _TABLE.findall(text):
        dtype = np.dtype(np.int32) if kind == "int32_t" else real
        numbers = [item.strip().removesuffix("f") for item in body.split(",")]
        found[name.removeprefix(f"{prefix}_")] = np.array(numbers).astype(dtype)
    return found


def dimension(package: CPackage, prefix: str, name: str) -> int:
    """A number of the header's enumeration."""
    found = re.search(rf"\b{prefix.upper()}_{name} = (-?\d+)", package.files[f"{prefix}.h"])
    assert found is not None
    return int(found[1])


def tree_of(package: CPackage, prefix: str) -> Tree:
    """The tree that the C walks."""
    table, size = tables(package, prefix), dimension(package, prefix, "COORDINATES")
    has_mirror = f"{prefix.upper()}_MIRROR" in package.files[f"{prefix}.h"]
    return Tree(
        table["normals"].reshape(-1, size),
        table["offsets"],
        np.column_stack([table["below"], table["above"]]),
        0,
        dimension(package, prefix, "MIRROR") if has_mirror else -1,
    )


def longest_walk(below: np.ndarray, above: np.ndarray) -> int:
    """Most nodes from the first one to a leaf; every node is entered from one other at the most."""
    children = np.concatenate([below, above])
    inner = children[children >= 0]
    assert len(set(inner.tolist())) == inner.size == below.size - 1
    longest, waiting = 0, [(0, 1)]
    while waiting:
        node, depth = waiting.pop()
        longest = max(longest, depth)
        waiting += [(int(c), depth + 1) for c in (below[node], above[node]) if c >= 0]
    return longest
