"""What the emitted C occupies on a target: tables, state, arguments, stack."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from servogen.wcet.allowance import Task
from servogen.wcet.targets import Target


@dataclass(frozen=True)
class Memory:
    """Bytes held against a target's memory. Code is not among them: only a compiler knows it.

    Attributes:
        state: the structures ``<prefix>_t`` that the caller owns -> bytes.
        arguments: the structures of arguments of the periodic entry points -> bytes.
        stack: entry point -> bytes of C objects on the stack. One for each deadline: a call with a
            shorter one may interrupt one with a longer one, and both are then on the stack.
        tables: constant objects -> bytes.
        data_limit, program_limit: of the target.
        together_limit: where both are the same memory, its size.
    """

    state: Mapping[str, int]
    arguments: Mapping[str, int]
    stack: Mapping[str, int]
    tables: Mapping[str, int]
    data_limit: int
    program_limit: int
    together_limit: int | None = None

    @property
    def data_bytes(self) -> int:
        """State, arguments and stack: what has to be in memory that can be written."""
        return sum(sum(part.values()) for part in (self.state, self.arguments, self.stack))

    @property
    def table_bytes(self) -> int:
        return sum(self.tables.values())

    @property
    def fits(self) -> bool:
        return not self.faults()

    def faults(self) -> list[str]:
        """One sentence for each memory that is too small, with what takes most of it."""
        data = {**self.arguments, **{f"stack of {n}": b for n, b in self.stack.items()}}
        data |= self.state
        kinds = [
            ("data", data, self.data_limit),
            ("tables", self.tables, self.program_limit),
        ]
        if self.together_limit is not None:
            kinds.append(("data and tables", {**data, **self.tables}, self.together_limit))
        found = []
        for what, parts, limit in kinds:
            used = sum(parts.values())
            if used > limit:
                most = max(sorted(parts), key=lambda name: parts[name])
                found.append(
                    f"{what} need {used} of {limit} bytes, most of it {most} ({parts[most]} bytes)"
                )
        return found

    def to_json(self) -> dict[str, object]:
        return {
            "fits": self.fits,
            "data_bytes": self.data_bytes,
            "data_limit_bytes": self.data_limit,
            "table_bytes": self.table_bytes,
            "table_limit_bytes": self.program_limit,
            "together_limit_bytes": self.together_limit,
            "state": dict(self.state),
            "arguments": dict(self.arguments),
            "stack": dict(self.stack),
        }


def occupied(
    tasks: Sequence[Task],
    state: Mapping[str, int],
    arguments: Mapping[str, int],
    tables: Mapping[str, int],
    target: Target,
) -> Memory:
    """Memory of a package whose periodic entry points are ``tasks``."""
    deepest: dict[float, Task] = {}
    for task in tasks:
        rival = deepest.get(task.deadline_s)
        if rival is None or task.count.stack_bytes > rival.count.stack_bytes:
            deepest[task.deadline_s] = task
    together = target.together_bytes
    return Memory(
        state=state,
        arguments=arguments,
        stack={task.name: task.count.stack_bytes for task in deepest.values()},
        tables=tables,
        data_limit=int(target.data_bytes.value),
        program_limit=int(target.program_bytes.value),
        together_limit=None if together is None else int(together.value),
    )
