"""A user's model for the tests."""

import casadi as ca

from servogen.plants.symbolic import SymbolicModel

CALLABLE_BUT_WRONG = dict


def servo() -> SymbolicModel:
    p, v, a, r = (ca.SX.sym(name) for name in "pvar")
    w, zeta = ca.SX.sym("w"), ca.SX.sym("zeta")
    jerk = w**3 * (r - p) - (1 + 2 * zeta) * (w**2 * v + w * a)
    return SymbolicModel(
        {"p": p, "v": v, "a": a}, {"r": r}, {"w": w, "zeta": zeta}, {"p": v, "v": a, "a": jerk}, p
    )


def raises() -> SymbolicModel:
    raise RuntimeError("no motor today\nand more lines")


def leaves() -> SymbolicModel:
    raise SystemExit(3)
