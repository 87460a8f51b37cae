"""The Eva drivers, how Frama-C's output is read, and (where it is) faults that it must find."""

from __future__ import annotations

import json
import shutil
import subprocess
from dataclasses import replace

import pytest
from core_designs import Variant, design, package, temporary_folder
from heavy_tools import needs_framac
from small_bench import bench, changed, subject

from servogen.controllers.cascade_design import declare_parts
from servogen.emit.driver import contract_file, contract_header, driver_file, is_driver
from servogen.emit.literals import real_literal
from servogen.emit.package import CPackage, emit_package
from servogen.evidence.prove import jobs_of, judge
from servogen.evidence.prove_bounds import binding, bound_places, judge_bounds
from servogen.evidence.prove_parts import Job
from servogen.evidence.prove_read import Proof, read_proof
from servogen.evidence.prove_run import INPUTS, prove
from servogen.evidence.tools import ToolMissing
from servogen.precision import PRECISIONS
from servogen.progress import Silent

SMALL = Variant("eva", horizon=3, points=8, ramp=2, cap=12)
BARE = Variant("eva0", horizon=0, points=5, ramp=0, precision="float32")
TINY = Variant("eva", horizon=2, points=4, ramp=0, cap=12)
DOUBLE = Variant("eva0", horizon=0, points=5, ramp=0)
WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-pedantic")


@pytest.mark.parametrize("v", [SMALL, BARE], ids=lambda v: v.prefix)
def test_drivers_call_every_entry_point_with_every_input(v):
    made = package(v)
    for d in made.declarations:
        text = made.files[driver_file(d.prefix)]
        for op in d.operations:
            body = text.partition(f"static void try_{op.name}(")[2].partition("\n}\n")[0]
            assert f" {d.prefix}_{op.name}(self" in body
            assert f"try_{op.name}(&self);" in text.partition("int main")[2]
            for port in op.inputs:
                assert port.low is not None
                values = (
                    (int(port.low), int(port.high))
                    if port.integer
                    else [real_literal(x, d.precision) for x in (port.low, port.high)]
                )
                assert f".{port.name}" + ("[i]" if port.size else "") + " = sg_draw" in body
                assert f"({values[0]}, {values[1]});" in body
            for port in op.outputs:
                low, high = ends(port, d.precision)
                out = f"out.{port.name}{'[i]' if port.size else ''}"
                if low == "-SG_REAL_MAX" and d.precision.name == "float64":
                    # as a real number the literal is less than the greatest double
                    assert f"\\is_finite({out});" in body
                    continue
                if "." in str(low) and d.precision.name == "float64":
                    low, high = f"{low}d", f"{high}d"
                assert f"{low} <= {out} <= {high};" in body


@pytest.mark.parametrize("v", [SMALL, BARE], ids=lambda v: v.prefix)
def test_contracts_promise_what_drivers_claim_and_no_more(v):
    made = package(v)
    used = {prefix for d in made.declarations for prefix in d.uses}
    assert len(used) == len(made.declarations) - 1
    for d in made.declarations:
        assert (contract_file(d.prefix) in made.files) == (d.prefix in used)
        if d.prefix not in used:
            continue
        contract, driver = made.files[contract_file(d.prefix)], made.files[driver_file(d.prefix)]
        for op in d.operations:
            body = contract.partition(f" {d.prefix}_{op.name}(")[2].partition("\n}\n")[0]
            for port in op.inputs:
                assert f"\\initialized(&in->{port.name}" in body
            for port in op.outputs:
                low, high = ends(port, d.precision)
                assert f"out->{port.name}{'[i]' if port.size else ''} = sg_promise" in body
                assert f"({low}, {high});" in body
        assert contract.count("&& self->begun == SG_BEGUN;") == len(d.operations)
        assert contract.count("interval(SG_OK, SG_UNREACHABLE)") == sum(
            op.returns_status for op in d.operations
        )
        shown = made.files[contract_header(d.prefix)]
        assert shown.count("SG_GIVEN") == 1 + sum(bool(member.bound) for member in d.state)
        for member in d.state:
            assert (f"self->{member.name}[i] = sg_promise" in contract) == bool(member.bound)
            assert (f"<= self->{member.name}[i] <=" in driver) == bool(member.bound)


def ends(port, precision):
    if port.low is None:
        return "-SG_REAL_MAX", "SG_REAL_MAX"
    if port.integer:
        return int(port.low), int(port.high)
    return real_literal(port.low, precision), real_literal(port.high, precision)


def test_drivers_are_listed_but_never_compiled():
    made = package(SMALL)
    drivers = [file for file in made.files if is_driver(file)]
    assert len(drivers) == 1 + 4 + 2 * 3  # how to draw, four controllers, three of them used
    assert not set(drivers) & set(made.sources)
    assert set(drivers) <= set(json.loads(made.files["manifest.json"])["files"])
    assert "verify" not in made.files["CMakeLists.txt"]
    again = emit_package(SMALL.prefix, declare_parts(design(SMALL)))
    assert {file: again.files[file] for file in drivers} == {f: made.files[f] for f in drivers}


@pytest.mark.parametrize("v", [SMALL, BARE], ids=lambda v: v.prefix)
def test_drivers_are_clean_c99(v):
    made, folder = package(v), temporary_folder("eva")
    made.write(folder)
    for d in made.declarations:
        for which in "12":
            command = ["gcc", "-std=c99", "-fsyntax-only", "-Werror", *WARNINGS, "-I."]
            command += [f"-DSG_EVA_INPUTS={which}", "-DSG_GIVEN=", driver_file(d.prefix)]
            command += [contract_file(prefix) for prefix in d.uses]
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stderr


LOG = """[eva] done for function main
[eva:summary] ====== ANALYSIS SUMMARY ======
  0 alarms generated by the analysis.
[metrics] Eva coverage statistics
  =======================
  Syntactically reachable functions = 4 (out of 31)
  Semantically reached functions = 4
  Coverage estimation = 100.0%
[metrics] Statements analyzed by Eva
  main: 14 stmts out of 14 (100.0%)
  try_step: 34 stmts out of 34 (100.0%)
  eva_governor_init: 5 stmts out of 5 (100.0%)
  eva_governor_step: 52 stmts out of 54 (96.3%)
"""
HEAD = "directory\tfile\tline\tfunction\tproperty kind\tstatus\tproperty\n"
GOOD = HEAD + (
    "FRAMAC_SHARE/libc\tx.h\t4\tf\tfrom clause\tConsidered valid\tassigns x;\n"
    "verify\teva_eva.h\t4\tFrama_C_nondet\tpostcondition\tConsidered valid\ta == b\n"
    "verify\teva_governor_eva.c\t50\ttry_step\tuser assertion\tValid\t\\is_finite(out.low_x)\n"
)


def read(code: int = 0, log: str = LOG, table: str = GOOD) -> Proof:
    return read_proof(code, log, table, package(SMALL).declarations[0])


def test_a_clean_run_is_read_as_proven():
    proof = read()
    assert proof.faults == ()
    assert (proof.proven, proof.functions) == (1, 4)
    assert proof.statements == (105, 107)
    assert proof.partly == ("eva_governor_step 52/54",)


ALARM = ".\ta.c\t9\tf\tis_nan_or_infinite\tUnknown\t\\is_finite(x)\n"
TRUST = ".\ta.c\t9\tf\tuser hypothesis\tConsidered valid\tx >= 0\n"
DEAD = "verify\teva_governor_eva.c\t51\ttry_step\tuser assertion\tDead\t\\is_finite(out.y)\n"
TROUBLE = {
    "an alarm": (0, LOG, GOOD + ALARM, "is_nan_or_infinite unknown"),
    "an assumption": (0, LOG, GOOD + TRUST, "takes on trust: x >= 0"),
    "a claim never reached": (0, LOG, GOOD + DEAD, "dead"),
    "a crash": (1, "[kernel] User Error: no", "", "Frama-C ends with status 1"),
    "no table": (0, LOG, "", "no table"),
    "no summary": (0, LOG.replace("ANALYSIS SUMMARY", ""), GOOD, "no summary"),
    "no end": (0, LOG + "[eva] f: NON TERMINATING FUNCTION", GOOD, "never ends"),
    "a warning": (0, LOG + "[kernel] a.c:1: Warning: \n  odd\n", GOOD, "warning of kernel: odd"),
    "an early end": (
        0,
        LOG.replace("14 stmts out of 14", "9 stmts out of 14"),
        GOOD,
        "main is not",
    ),
    "no step": (0, LOG.replace("eva_governor_step", "other"), GOOD, "step is not analysed"),
    "a lost call": (
        0,
        LOG.replace("reached functions = 4", "reached functions = 3"),
        GOOD,
        "3 of 4",
    ),
    "no coverage": (0, LOG.replace("Semantically", ""), GOOD, "no figures of coverage"),
}


@pytest.mark.parametrize("name", TROUBLE)
def test_whatever_is_not_understood_is_a_fault(name):
    code, log, table, expected = TROUBLE[name]
    faults = read(code, log, table).faults
    assert any(expected in fault for fault in faults), faults


def test_the_finding_fails_with_any_run_and_with_none():
    both = bench(SMALL)
    jobs = jobs_of(both)
    assert {(j.precision, j.declaration.prefix, j.inputs) for j in jobs} == {
        (s.precision.name, d.prefix, inputs)
        for s in both.subjects
        for d in s.package.declarations
        for inputs in INPUTS
    }
    good, bad = read(), read(table=GOOD + ALARM)
    if shutil.which("frama-c") is None:
        pytest.skip("the finding names Frama-C's version")
    assert judge(both, jobs, [good] * len(jobs), {}).passed
    failed = judge(both, jobs, [bad] + [good] * (len(jobs) - 1), {})
    assert not failed.passed
    assert failed.faults[0].startswith("float64: eva_governor, finite inputs: a.c:9")
    assert not judge(both, [], [], {}).passed


def test_without_the_tool_the_check_does_not_run(monkeypatch):
    from servogen.evidence import prove as check

    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(ToolMissing, match="frama-c-base"):
        check.run(bench(SMALL), Silent())


def test_no_bound_binds_in_a_closed_loop(tmp_path):
    figures, faults = judge_bounds(subject(SMALL), tmp_path)
    assert faults == []
    assert figures["closed_loop"] == {}
    assert figures["suite"]  # on garbage they do: the counting works
    assert figures["places"] == bound_places(package(SMALL)) > 5
    assert figures["closed_loop_calls"] > 50


def test_a_bound_that_binds_in_the_closed_loop_is_counted(tmp_path):
    made = package(SMALL)
    table = made.files["eva_mpc_tables.h"]
    place = table.index("eva_mpc_bound[3] = {")
    end = table.index("}", place)
    narrow = f"{table[:place]}eva_mpc_bound[3] = {{ 0.01, 0.01, 0.01 {table[end:]}"
    tight = replace(made, files={**made.files, "eva_mpc_tables.h": narrow})
    one = subject(SMALL, tight)
    assert sum(binding(one, one.closed_loops(None), tmp_path).values()) > 0


def proof_of(made: CPackage, prefix: str, inputs: str) -> Proof:
    folder = temporary_folder("eva")
    made.write(folder)
    d = next(d for d in made.declarations if d.prefix == prefix)
    return prove(Job(made, d, inputs), folder)


FAST, GOVERNOR, CASCADE = "eva0_follower", "eva0_governor", "eva0"
# controller, inputs, file, what stands there, what is planted
FAULTS = {
    "state not bounded": (
        FAST, "finite", f"{FAST}.c",
        "sg_bound(self->scratch_x", "sg_first(self->scratch_x",
    ),
    "one too far in the ring": (
        FAST, "finite", f"{FAST}.c",
        "index >= EVA0_FOLLOWER_BUFFER", "index > EVA0_FOLLOWER_BUFFER",
    ),
    "a member not cleared": (
        FAST, "finite", f"{FAST}.c",
        "    self->along = (sg_real)0;\n    self->rate_begin", "    self->rate_begin",
    ),
    "a check of the wrong input": (
        FAST, "any", f"{FAST}.c",
        "in->x_velocity, -2.8f, 2.8f", "in->x_position, -0.6f, 0.6f",
    ),
    "an output beyond its range": (
        FAST, "finite", f"{FAST}.c",
        "sg_bound(eva0_follower_point(self, self->path_x)",
        "sg_first(eva0_follower_point(self, self->path_x)",
    ),
    "a member of a part that nobody promised": (
        CASCADE, "finite", f"{CASCADE}.c",
        "sg_bound(ahead_x[i], -eva0_bound_x[i], eva0_bound_x[i])", "self->fast.state_x[i]",
    ),
    "a member of a part written": (
        CASCADE, "finite", f"{CASCADE}.c",
        "    self->planned = 0;\n    self->priming",
        "    self->fast.state_x[0] = self->state_x[0];\n    self->planned = 0;\n    self->priming",
    ),
    "a part never begun": (
        CASCADE, "finite", f"{CASCADE}.c",
        "    eva0_governor_init(&self->governor);\n", "",
    ),
    "a part asked with what was never written": (
        CASCADE, "finite", f"{CASCADE}.c",
        "    ask.last_x = self->reference_x[EVA0_HORIZON];\n", "",
    ),
    "a check that a NaN passes": (
        GOVERNOR, "any", "sg_kernels.h",
        "    if (!(x == x)) {\n", "    if (x > x) {\n",
    ),
    "an index of an input not checked": (  # the count is any int32
        GOVERNOR, "finite", f"{GOVERNOR}.c",
        "    int32_t taken = 0;\n",
        "    int32_t taken = 0;\n    taken = in->n_points + 2147483000;\n    taken = 0;\n",
    ),
    "a product of an input not checked": (  # a number is any finite one
        GOVERNOR, "finite", f"{GOVERNOR}.c",
        "    int32_t taken = 0;\n",
        "    int32_t taken = 0;\n    self->least_x[0] = in->x_velocity * 1.0e3f;\n",
    ),
    "a case that only a refusal of a part has": (
        CASCADE, "finite", f"{CASCADE}.c",
        "    status = sg_worse(status, pushed);\n",
        "    status = sg_worse(status, pushed);\n"
        "    self->reference_x[(pushed == SG_OVERFLOW) ? 99999 : 0] = (sg_real)0;\n",
    ),
    "an infinity that is clamped away": (
        GOVERNOR, "finite", f"{GOVERNOR}.c",
        "    int32_t taken = 0;\n",
        "    int32_t taken = 0;\n"
        "    self->least_x[0] = sg_clamp_any(in->x_velocity * 9.0e30f, -1.0f, 1.0f);\n",
    ),
    "a driver that never calls step": (
        GOVERNOR, "finite", f"verify/{GOVERNOR}_eva.c",
        "            try_step(&self);\n", "",
    ),
}  # fmt: skip


@needs_framac
@pytest.mark.parametrize("prefix", ["eva0_governor", "eva0_follower", "eva0"])
@pytest.mark.parametrize("inputs", INPUTS)
@pytest.mark.parametrize("v", [BARE, DOUBLE], ids=["float32", "float64"])
def test_small_controllers_are_proven(prefix, inputs, v):
    proof = proof_of(package(v), prefix, inputs)
    assert proof.faults == ()
    assert proof.alarms == {}
    assert proof.proven > 8


@needs_framac
@pytest.mark.parametrize("prefix", ["eva_mpc", "eva"])
def test_a_predictive_cascade_is_proven(prefix):
    proof = proof_of(package(TINY), prefix, "any")
    assert proof.faults == ()
    assert proof.proven > 8


@needs_framac
def test_a_state_beyond_what_the_contract_gives_is_found():
    old = "sg_bound(self->predicted[i], -eva_mpc_bound[i], eva_mpc_bound[i])"
    made = changed(package(TINY), "eva_mpc.c", old, f"((sg_real)2 * {old})")
    assert any("predicted" in fault for fault in proof_of(made, "eva_mpc", "finite").faults)


@needs_framac
@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_found(name):
    prefix, inputs, file, old, new = FAULTS[name]
    made = changed(package(BARE), file, old, new)
    if "sg_first" in new:
        kernels = made.files["sg_kernels.h"]
        first = "static inline sg_real sg_first(sg_real x, sg_real low, sg_real high)\n"
        first += "{\n    (void)low;\n    (void)high;\n    return x;\n}\n\n"
        anchor = "static inline sg_real sg_min("
        files = {**made.files, "sg_kernels.h": kernels.replace(anchor, first + anchor, 1)}
        made = replace(made, files=files)
    proof = proof_of(made, prefix, inputs)
    assert proof.faults, name


def test_both_precisions_are_proven_about():
    assert {s.precision for s in bench(SMALL).subjects} == set(PRECISIONS.values())
