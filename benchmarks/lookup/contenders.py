"""Everyone who finds a first move: servogen's forms, sequential search, PPOPT, solvers on line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from ppopt_peer import ppopt_solution
from qp.counted import Measured, PeerFailed, compile_peer, counted_peer
from qp.peers import columns, daqp
from qp.sequence import Array, with_optima

from lookup.programs import Program
from servogen.controllers.lookup_design import declare_lookup, design_lookup
from servogen.emit.literals import real_literal
from servogen.emit.package import emit_package
from servogen.errors import InputError
from servogen.explicit.choose import Choice, Form, choose
from servogen.explicit.clips import recursive_clips, without_first_bounds
from servogen.explicit.explore import solve
from servogen.explicit.grow import grow_tree
from servogen.explicit.lookup import count_clips, tree_lookup
from servogen.explicit.solution import ExplicitSolution
from servogen.precision import PRECISIONS
from servogen.qp.errors import ProgramError
from servogen.sets.errors import SetError

HERE = Path(__file__).parent / "c"
DOUBLE = PRECISIONS["float64"]
MAX_REGIONS = 5000
# A law tree with more regions takes minutes to grow.
MOST_REGIONS = 100
# Work on the depth of trees, as a project spends it by default.
SEARCH = 2000
# A row is kept within this share of its size, so that no point falls between two regions.
SEAM = 1e-9

CHOSEN = "servogen, chosen form"
CHECKED = "servogen, chosen form, parameter checked"
LAW_TREE, CLIP_TREE = "servogen, law tree", "servogen, clip tree"
CLIPS = "servogen, recursive clips"
SEQUENTIAL = "sequential search"
PPOPT = "PPOPT's regions, its point location"
PPOPT_SEQUENTIAL = "PPOPT's regions, sequential search"
PPOPT_CODE = "PPOPT, generated C++"
DAQP_ONLINE = "DAQP, on line"
OWN_ONLINE = "servogen, active set on line"

Contender = Callable[["Explicit", Path], Measured]


@dataclass
class Explicit:
    """A program with what is explicit of it, made when first asked for."""

    program: Program

    @cached_property
    def choice(self) -> Choice:
        return choose(self.program.free, MAX_REGIONS, SEARCH)

    @cached_property
    def own(self) -> ExplicitSolution:
        return self.choice.own or solve(self.program.free, MAX_REGIONS)

    @cached_property
    def theirs(self) -> tuple[object, Array, Array]:
        """PPOPT's solution, and the units of its variables and parameters."""
        algorithm = "combinatorial" if self.program.qp.is_box else "geometric"
        solution, _, sizes, extent = ppopt_solution(self.program.qp, algorithm, process=True)
        return solution, sizes, extent


def _emitted(given: Explicit, form: Form, folder: Path, name: str, call: str) -> Measured:
    try:
        design = design_lookup(
            "sgl", DOUBLE, given.program.free, given.choice, 1e-3, MAX_REGIONS, form=form
        )
    except InputError as why:
        raise PeerFailed(str(why)) from why
    declared = declare_lookup(design)
    package = emit_package("sgl", (declared,))
    package.write(folder)
    program = compile_peer(
        folder, [HERE / "emitted.c", *(folder / source for source in package.sources)],
        extra=["-std=c99", f"-DTABLE_BYTES={declared.table_bytes}", f"-DCALL=sgl_{call}"],
    )  # fmt: skip
    return _measured(name, given, program, note=f"{form.name}: {form.note}")


def _measured(
    name: str, given: Explicit, program: Path, static: bool = False, note: str = ""
) -> Measured:
    asked = given.program.asked()
    return counted_peer(name, program, asked, slice(0, asked.length), static, note)


def chosen(given: Explicit, folder: Path) -> Measured:
    return _emitted(given, given.choice.chosen, folder, CHOSEN, "solve")


def checked(given: Explicit, folder: Path) -> Measured:
    return _emitted(given, given.choice.chosen, folder, CHECKED, "find")


def law_tree(given: Explicit, folder: Path) -> Measured:
    return _tree(given, None, given.program, folder, LAW_TREE)


def clip_tree(given: Explicit, folder: Path) -> Measured:
    try:
        free, clip = without_first_bounds(given.program.free)
    except (ProgramError, SetError, InputError) as why:
        raise PeerFailed(f"cannot be had: {why}") from why
    return _tree(given, clip, replace(given.program, free=free), folder, CLIP_TREE)


def _tree(
    given: Explicit, clip: tuple[float, float] | None, of: Program, folder: Path, name: str
) -> Measured:
    kind = name.removeprefix("servogen, ")
    for form in given.choice.forms:
        if form.name == kind and form.lookup is not None:
            return _emitted(given, form, folder, name, "solve")
    solution = given.own if clip is None else solve(of.free, MAX_REGIONS)
    if len(solution.regions) > MOST_REGIONS:
        raise PeerFailed(f"not grown: {len(solution.regions)} regions")
    tree = grow_tree(solution, SEARCH)
    lookup = tree_lookup(solution, tree, clip)
    note = f"{len(solution.regions)} regions, {tree.nodes} nodes, depth {tree.depth}"
    return _emitted(given, Form(kind, lookup, lookup.count, note, solution), folder, name, "solve")


def clips(given: Explicit, folder: Path) -> Measured:
    try:
        found = recursive_clips(given.program.free)
    except (ProgramError, SetError, InputError) as why:
        raise PeerFailed(f"cannot be had: {why}") from why
    form = Form("recursive clips", found, count_clips(found), f"{found.index.size} clips")
    return _emitted(given, form, folder, CLIPS, "solve")


def _tables(path: Path, sizes: Mapping[str, int], tables: Mapping[str, Array]) -> None:
    lines = [f"enum {{ {', '.join(f'{name} = {value}' for name, value in sizes.items())} }};"]
    for name, values in tables.items():
        whole = np.issubdtype(values.dtype, np.integer)
        kind = "short" if whole else "double"
        words = [str(int(v)) if whole else real_literal(float(v), DOUBLE) for v in values.ravel()]
        lines.append(f"static const {kind} {name}[{len(words)}] = {{ {', '.join(words)} }};")
    path.write_text("\n".join(lines) + "\n")


def sequential(given: Explicit, folder: Path) -> Measured:
    """servogen's regions in their order, in the coordinates of its trees; laws stored once."""
    solution = given.own
    image, regions = solution.image, solution.regions
    heights = np.concatenate([region.k for region in regions])
    sizes = {
        "PARAMETERS": given.program.theta.shape[1], "COORDINATES": image.matrix.shape[0],
        "MOVES": given.program.free.first_move, "REGIONS": len(regions), "FACETS": heights.size,
    }  # fmt: skip
    starts = np.cumsum([0, *(region.k.size for region in regions)])
    _tables(folder / "regions.h", sizes, {
        "matrix": image.matrix, "shift": image.offset, "starts": starts,
        "normals": np.vstack([region.h for region in regions]),
        "heights": heights + SEAM * (1.0 + np.abs(heights)), "laws": solution.law_of,
        "gains": solution.laws.gains, "constants": solution.laws.offsets,
    })  # fmt: skip
    program = compile_peer(folder, [HERE / "regions.c"], extra=["-std=c99", "-DIMAGE"])
    return _measured(SEQUENTIAL, given, program, True, f"{len(regions)} regions")


def _ppopt(given: Explicit, folder: Path, name: str, *options: str) -> Measured:
    solution, sizes_, extent = given.theirs
    regions = solution.critical_regions  # type: ignore[attr-defined]
    moves = given.program.free.first_move
    normals = np.vstack([np.asarray(region.E) for region in regions])
    heights = np.concatenate([np.ravel(region.f) for region in regions])
    gains = np.stack([np.asarray(region.A)[:moves] for region in regions])
    constants = np.stack([np.ravel(region.b)[:moves] for region in regions])
    sizes = {
        "PARAMETERS": extent.size, "COORDINATES": extent.size, "MOVES": moves,
        "REGIONS": len(regions), "FACETS": heights.size,
    }  # fmt: skip
    starts = np.cumsum([0, *(np.size(region.f) for region in regions)])
    _tables(folder / "regions.h", sizes, {
        "starts": starts, "normals": normals / extent,
        "heights": heights + SEAM * (1.0 + np.abs(heights)), "laws": np.arange(len(regions)),
        "gains": gains * sizes_[:moves, None] / extent, "constants": constants * sizes_[:moves],
    })  # fmt: skip
    program = compile_peer(folder, [HERE / "regions.c"], extra=["-std=c99", *options])
    return _measured(name, given, program, True, f"{len(regions)} regions")


def ppopt(given: Explicit, folder: Path) -> Measured:
    """Its regions, and the algorithm of its ``PointLocation``, in our C."""
    return _ppopt(given, folder, PPOPT, "-DALL_ROWS")


def ppopt_sequential(given: Explicit, folder: Path) -> Measured:
    return _ppopt(given, folder, PPOPT_SEQUENTIAL)


def ppopt_code(given: Explicit, folder: Path) -> Measured:
    """What its generator gives, where it runs."""
    try:
        from ppopt.upop.linear_code_gen import generate_code_cpp

        text = generate_code_cpp(given.theirs[0], "double")
    except Exception as why:
        raise PeerFailed(f"its generator does not run: {type(why).__name__}: {why}") from why
    (folder / "ppopt.cpp").write_text(text)
    raise PeerFailed("its generator runs, to work/.../ppopt.cpp: no harness calls that yet")


def _online(given: Explicit, folder: Path, name: str) -> Measured:
    sequence = with_optima(given.program.online())
    peer = {DAQP_ONLINE: daqp, OWN_ONLINE: columns}[name]
    found = peer(sequence, slice(0, sequence.length), folder)
    return replace(found, solver=name, note="f given, not made of the parameter")


CONTENDERS: tuple[tuple[str, Contender], ...] = (
    (CHOSEN, chosen),
    (CHECKED, checked),
    (LAW_TREE, law_tree),
    (CLIP_TREE, clip_tree),
    (CLIPS, clips),
    (SEQUENTIAL, sequential),
    (PPOPT, ppopt),
    (PPOPT_SEQUENTIAL, ppopt_sequential),
    (PPOPT_CODE, ppopt_code),
    (OWN_ONLINE, lambda given, folder: _online(given, folder, OWN_ONLINE)),
    (DAQP_ONLINE, lambda given, folder: _online(given, folder, DAQP_ONLINE)),
)
OWN = (CHOSEN, CHECKED, LAW_TREE, CLIP_TREE, CLIPS)
# What the chosen form is never to be slower than.
BEATEN = (SEQUENTIAL, PPOPT, PPOPT_SEQUENTIAL, PPOPT_CODE)
