"""``qp_mpc20b``: 1698 programs of a closed loop, kept in this folder in a compact form.

The rows of position, velocity and acceleration are bounded by constants less the free response of a
plant with three states, so that three numbers per program stand for 60 rows; the program is what
``unpack`` makes of the file, within 1e-13 of the sequence it was packed from.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from qp.sequence import Array, Sequence, StagePlant

FILE = Path(__file__).parent / "qp_mpc20b.npz"
HORIZON, PER_STEP, TERMINAL, STATES = 20, 4, 3, 3
COUNT = PER_STEP * HORIZON + TERMINAL
# rows whose bounds know the reference: the tracking error's and those of the end
FREE = np.append(np.arange(3, PER_STEP * HORIZON, PER_STEP), np.arange(COUNT - TERMINAL, COUNT))
OTHERS = np.setdiff1d(np.arange(COUNT), FREE)


def pack(source: Path, target: Path) -> float:
    """Write the compact form of H, G, f, w; returns the largest difference of what it gives."""
    data = np.load(source)
    rows, high, low = data["G"][:COUNT], data["w"][:, :COUNT], -data["w"][:, COUNT:]
    middle = high[:, OTHERS].mean(axis=0)
    left, size, right = np.linalg.svd(high[:, OTHERS] - middle, full_matrices=False)
    state = left[:, :STATES] * size[:STATES]
    np.savez_compressed(
        target,
        hessian=data["H"],
        rows=rows,
        state=state,
        onto=right[:STATES],
        middle=middle,
        width=(high - low)[0],
        linear=data["f"],
        free=high[:, FREE],
        free_width=(high - low)[:, FREE],
    )
    made = unpack(target)
    return max(
        float(np.max(np.abs(made.high - high))),
        float(np.max(np.abs(made.low - low))),
    )


def unpack(path: Path = FILE) -> Sequence:
    data = np.load(path)
    state = data["state"]
    high = np.empty((len(state), COUNT))
    high[:, OTHERS] = state @ data["onto"] + data["middle"]
    high[:, FREE] = data["free"]
    width = np.tile(data["width"], (len(state), 1))
    width[:, FREE] = data["free_width"]
    return Sequence(
        name="qp_mpc20b",
        source="1698 programs of a two-stage machine's closed loop, horizon 20",
        hessian=data["hessian"],
        rows=data["rows"],
        linear=data["linear"],
        low=high - width,
        high=high,
        per_step=PER_STEP,
        staying=TERMINAL,
        plant=plant_of(data["rows"]),
    )


def responses(rows: Array) -> Array:
    """(4, N) responses of the rows of a step to a command some steps before."""
    return np.stack([rows[i : PER_STEP * HORIZON : PER_STEP][-1][::-1] for i in range(PER_STEP)])


def plant_of(rows: Array) -> StagePlant:
    """The plant behind the rows, in the coordinates of its first three outputs."""
    response = responses(rows)
    three = response[:STATES]
    phi = np.linalg.lstsq(three[:, :-1].T, three[:, 1:].T, rcond=None)[0].T
    stage = np.column_stack([phi, three[:, 0]])
    # the tracking error's row is the position's by another limit
    outer = np.zeros((1, STATES + 1))
    outer[0, 0] = response[3, 0] / response[0, 0]
    last = rows[PER_STEP * HORIZON :, ::-1]
    terminal = np.linalg.lstsq(three.T, last.T, rcond=None)[0].T
    return StagePlant(stage, terminal, STATES, outer=outer)
