"""All controllers of a servo axis: what is emitted together."""

from __future__ import annotations

from dataclasses import dataclass, replace

from servogen.controllers.design import Declaration
from servogen.controllers.errors import DesignError
from servogen.controllers.lookup import Lookup
from servogen.controllers.lookup_design import LookupDesign, declare_lookup
from servogen.controllers.pid_design import PidDesign, declare_pid
from servogen.controllers.servo_mpc import ServoMpc
from servogen.controllers.servo_mpc_design import (
    ServoMpcDesign,
    declare_servo_mpc,
    lookup_prefix,
)


@dataclass(frozen=True)
class ServoParts:
    """The MPC with its lookup, and the PID that it replaces, if there is one.

    Raises:
        DesignError: a lookup that is not this MPC's, or that does not reach as far.
    """

    mpc: ServoMpcDesign
    lookup: LookupDesign
    pid: PidDesign | None = None

    def __post_init__(self) -> None:
        fits = (lookup_prefix(self.mpc), self.mpc.problem.layout.size, self.mpc.precision)
        found = (self.lookup.prefix, self.lookup.parameters, self.lookup.precision)
        if fits != found:
            raise DesignError("lookup", str(found), str(fits))
        bound = self.mpc.parameter_bound  # a step does not have its parameter looked at again
        if not bound <= self.lookup.reach:
            expected = f"one for parameters up to {bound:.3g}"
            raise DesignError("lookup", f"up to {self.lookup.reach:.3g}", expected)

    def declarations(self) -> tuple[Declaration, ...]:
        """Those used before those that use them; the MPC is the second."""
        pid: tuple[Declaration, ...] = ()
        if self.pid is not None:
            pid = (replace(declare_pid(self.pid), replaces=self.mpc.prefix),)
        return (declare_lookup(self.lookup), declare_servo_mpc(self.mpc), *pid)

    def controller(self) -> ServoMpc:
        """The MPC's reference with the lookup that is emitted."""
        return ServoMpc(self.mpc, Lookup(self.lookup))
