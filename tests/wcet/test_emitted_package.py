"""The bundled example: counted, and run with the counting build over ordinary and wild inputs."""

from __future__ import annotations

import ctypes
import random
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from servogen.controllers.design import Declaration, Port
from servogen.emit.package import CPackage
from servogen.progress import Silent
from servogen.project import load_project
from servogen.resources import resource_dir
from servogen.steps.counted import count_emitted
from servogen.steps.prepare import prepare
from servogen.wcet.dynamic import CountedLibrary, build_counted
from servogen.wcet.operations import OperationCounts
from servogen.wcet.package import PackageCount


@dataclass(frozen=True)
class Counted:
    package: CPackage
    counts: PackageCount
    library: CountedLibrary

    @property
    def cascade(self) -> Declaration:
        return self.package.declarations[-1]


@pytest.fixture(scope="module")
def example(tmp_path_factory: pytest.TempPathFactory) -> Counted:
    project = load_project(resource_dir("examples") / "two_stage" / "servogen.toml")
    package = prepare(project, Silent()).package
    folder = tmp_path_factory.mktemp("emitted")
    package.write(folder)
    sources = [folder / name for name in package.sources]
    library = build_counted(sources, [folder], folder / "counted")
    return Counted(package, count_emitted(package), library)


def structure(ports: tuple[Port, ...], real: type) -> type[ctypes.Structure]:
    """The C struct of these inputs or outputs."""

    def kind(port: Port) -> type:
        scalar = ctypes.c_int32 if port.integer else real
        return scalar * port.size if port.size else scalar

    return type("Struct", (ctypes.Structure,), {"_fields_": [(p.name, kind(p)) for p in ports]})


@dataclass
class Machine:
    """The cascade of the example, called through ctypes with its counters read after each call."""

    example: Counted

    def __post_init__(self) -> None:
        real = ctypes.c_float if self.example.counts.precision == "float32" else ctypes.c_double
        self.structs = {
            (op.name, way): structure(ports, real)
            for op in self.example.cascade.operations
            for way, ports in (("in", op.inputs), ("out", op.outputs))
        }
        self.memory = ctypes.create_string_buffer(1 << 20)
        self.call("init")

    def call(self, name: str, **inputs: object) -> tuple[ctypes.Structure | None, OperationCounts]:
        function = getattr(self.example.library.functions, f"{self.example.cascade.prefix}_{name}")
        arguments: list[object] = [self.memory]
        out = None
        if name != "init":
            given, result = self.structs[name, "in"](), self.structs[name, "out"]()
            for key, value in inputs.items():
                field = getattr(given, key)
                if isinstance(field, ctypes.Array):
                    field[:] = value
                else:
                    setattr(given, key, value)
            operation = self.example.cascade.operation(name)
            arguments += [ctypes.byref(given)] if operation.inputs else []
            arguments += [ctypes.byref(result)] if operation.outputs else []
            out = result
        self.example.library.reset()
        function(*arguments)
        ran = self.example.library.read()
        entry = f"{self.example.cascade.prefix}_{name}"
        bound = self.example.counts.entry_points[entry].total()
        assert bound.covers(ran), f"{entry}: {ran} above {bound}"
        return out, ran


def random_steps(rng: random.Random, number: int) -> Iterator[dict[str, object]]:
    """States from standing still to far too fast, points from one place to all over."""
    for _ in range(number):
        spread, speed = rng.choice([0.0, 1e-3, 0.03]), rng.choice([0.0, 0.1, 2.0])
        inputs: dict[str, object] = {"n_points": rng.choice([0, 1, 75, 150])}
        for axis in "xy":
            here = rng.uniform(-0.3, 0.3)
            inputs[f"{axis}_position"] = here
            inputs[f"{axis}_velocity"] = rng.uniform(-speed, speed)
            inputs[f"{axis}_acceleration"] = rng.uniform(-speed, speed) * 10
            inputs[f"points_{axis}"] = [here + rng.uniform(-spread, spread) for _ in range(150)]
        if rng.random() < 0.1:
            inputs["x_position"] = float("nan")
        yield inputs


def test_a_run_never_exceeds_the_count(example: Counted) -> None:
    machine = Machine(example)
    rng = random.Random(7)
    reached = 0
    for start in range(3):
        machine.call("reset", position_x=0.1 * start, position_y=-0.1)
        for inputs in random_steps(rng, 30):
            out, _ = machine.call("step", **inputs)
            reached = max(reached, out.iterations_x, out.iterations_y)  # type: ignore[union-attr]
            machine.call("fast_step")
    cap = max(example.counts.entry_points[f"{example.package.name}_step"].caps.values())
    assert reached == cap  # the worst case was among them


def test_the_start_is_counted_exactly(example: Counted) -> None:
    _, ran = Machine(example).call("init")
    assert ran == example.counts.entry_points[f"{example.package.name}_init"].total()


def test_tables_are_those_of_the_design(example: Counted) -> None:
    parts = example.package.declarations
    assert example.counts.total_table_bytes == sum(d.table_bytes for d in parts)


def test_counts_do_not_depend_on_the_folder(example: Counted, tmp_path: Path) -> None:
    again = count_emitted(example.package)
    assert again.to_json() == example.counts.to_json()
    assert str(tmp_path.parent) not in str(again.to_json())
