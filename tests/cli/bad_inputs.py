"""The table of bad inputs: what is changed in a good project, and what the message must say."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from small_project import dxf, line

import servogen.wcet.targets

Change = Callable[[Path], None]


@dataclass(frozen=True)
class Bad:
    """A kind of bad input.

    Attributes:
        name: what is wrong.
        change: spoils a good project, given its project file.
        says: fragments of the one line on standard error.
        file: last part of the name of the file that the line begins with.
    """

    name: str
    change: Change
    says: tuple[str, ...]
    file: str = "servogen.toml"


def edit(old: str, new: str) -> Change:
    """Replace the first place of a text that must be in the project file."""

    def change(toml: Path) -> None:
        text = toml.read_text()
        assert old in text
        toml.write_text(text.replace(old, new, 1))

    return change


def bytes_of(data: bytes) -> Change:
    """Another content of the project file."""
    return lambda toml: toml.write_bytes(data) and None


def drawing(name: str, content: str | bytes) -> Change:
    """Another drawing."""

    def change(toml: Path) -> None:
        edit('"line.dxf"', f'"{name}"')(toml)
        data = content.encode() if isinstance(content, str) else content
        (toml.parent / name).write_bytes(data)

    return change


def svg(body: str) -> str:
    """A drawing of these elements, a pixel to the unit."""
    return f'<svg xmlns="http://www.w3.org/2000/svg">{body}</svg>'


def both(*changes: Change) -> Change:
    """One after the other."""

    def change(toml: Path) -> None:
        for one in changes:
            one(toml)

    return change


def model_file(source: str, function: str = "stage") -> Change:
    """x's slow stage as a user's Python model."""

    def change(toml: Path) -> None:
        (toml.parent / "model.py").write_text(source)
        edit(SERVO, f'model = "python"\nfile = "model.py"\nfunction = "{function}"\n')(toml)

    return change


SERVO = 'model = "servo"\nbandwidth_rad_per_s = 45.0\ndamping = 0.7\n'


def slow(text: str) -> Change:
    """Another model of x's slow stage."""
    return edit(SERVO, text + "\n")


def slow_tf(numerator: str, denominator: str) -> Change:
    """x's slow stage as a transfer function."""
    return slow(
        f'model = "transfer_function"\nnumerator = {numerator}\ndenominator = {denominator}'
    )


def slow_ss(a: str, b: str, c: str) -> Change:
    """x's slow stage as a state space."""
    return slow(f'model = "state_space"\na = {a}\nb = {b}\nc = {c}')


FORMAT = (
    Bad("no project file", lambda toml: toml.unlink(), ("missing", "a TOML file")),
    Bad(
        "empty project file",
        bytes_of(b""),
        ("schema is missing, expected 1", "(and 5 more wrong keys)"),
    ),
    Bad("not UTF-8", bytes_of(b'schema = 1\nname = "\xff"\n'), ("line 2", "0xff", "UTF-8")),
    Bad("no TOML", edit("damping = 0.7", "damping 0.7"), ("line 8", '"damping 0.7"', "'='")),
    Bad("unclosed table", edit("[sampling]", "[sampling"), ("line 21", '"[sampling"', "']'")),
    Bad(
        "key given twice",
        edit("damping = 0.7", "damping = 0.7\ndamping = 0.8"),
        ("line 9", "damping = 0.8", "cannot overwrite"),
    ),
    Bad("huge file", bytes_of(b"#" * 2_000_000), ("its size", "2000000 bytes", "at most")),
    Bad(
        "number of 5000 digits",
        edit("damping = 0.7", "damping = " + "9" * 5000),
        ("a whole number of thousands of digits",),
    ),
    Bad(
        "tables nested without end",
        edit("damping = 0.7", "a" + ".a" * 5000 + " = 1"),
        ("the file", "nested"),
    ),
    Bad("another format version", edit("schema = 1", "schema = 2"), ("schema is 2", "expected 1")),
)

KEYS = (
    Bad(
        "missing key",
        edit("damping = 0.7\n", ""),
        ("machine.x.slow.damping is missing", "a finite number above 0 and at most 5"),
    ),
    Bad(
        "missing table",
        edit("[sampling]", "[output2]"),
        ("output2", "output (the", "(and 1 more wrong key)"),
    ),
    Bad(
        "no drawing named",
        edit('file = "line.dxf"\n', ""),
        ("path.file is missing", ".dxf"),
    ),
    Bad(
        "unknown key with a close one",
        edit("damping = 0.7", "dampng = 0.7"),
        ("machine.x.slow.dampng", "unknown key (0.7)", "damping (the closest"),
    ),
    Bad(
        "unknown key that belongs elsewhere",
        edit("[controller.mpc]", "[controller]\nhorizon = 3\n[controller.mpc]"),
        ("controller.horizon", "(3)", "it at controller.mpc.horizon"),
    ),
    Bad(
        "unknown key like no other",
        edit("[output]", "[output]\nzzz = true"),
        ("output.zzz", "(true)", "one of the keys precision"),
    ),
    Bad(
        "unit in millimetres",
        edit("range_m = 0.035", "range_mm = 35"),
        ("machine.x.fast.range_mm", "another unit (35)", "range_m, in m"),
    ),
    Bad(
        "bandwidth in hertz",
        edit("bandwidth_rad_per_s = 45.0", "bandwidth_hz = 7.2"),
        ("machine.x.slow.bandwidth_hz", "(7.2)", "bandwidth_rad_per_s, in rad/s"),
    ),
    Bad(
        "two mistakes, the first one told and the other counted",
        both(edit("damping = 0.7", "damping = 7.0"), edit("horizon = 3", "horizon = 0")),
        ("machine.x.slow.damping is 7.0", "(and 1 more wrong key)"),
    ),
    Bad(
        "y both as x and of its own",
        edit("[sampling]", '[machine.y]\nsame_as = "x"\nslow = {}\n[sampling]'),
        ("machine.y.slow is a table", "not both"),
    ),
    Bad(
        "y as an axis that is not there",
        edit("[sampling]", '[machine.y]\nsame_as = "z"\n[sampling]'),
        ('machine.y.same_as is "z"', '"x"'),
    ),
)

VALUES = (
    Bad("text for a number", edit("damping = 0.7", 'damping = "0.7"'), ('damping is "0.7"',)),
    Bad("true for a number", edit("damping = 0.7", "damping = true"), ("damping is true",)),
    Bad("NaN", edit("damping = 0.7", "damping = nan"), ("damping is nan", "a finite number")),
    Bad("infinity", edit("= 14.71", "= inf"), ("acceleration_limit_m_per_s2 is inf", "m/s^2")),
    Bad("negative limit", edit("= 14.71", "= -1"), ("_m_per_s2 is -1", "above 0")),
    Bad("zero range", edit("= 0.035", "= 0"), ("machine.x.fast.range_m is 0", "above 0", "(m)")),
    Bad("limit in millimetres", edit("= 0.4", "= 400"), ("position_limit_m is 400", "100 (m)")),
    Bad("huge horizon", edit("horizon = 3", "horizon = 5000"), ("horizon is 5000", "at most 60")),
    Bad("horizon no integer", edit("horizon = 3", "horizon = 2.5"), ("horizon is 2.5", "whole")),
    Bad(
        "unknown model",
        slow('model = "piezo"'),
        ('machine.x.slow.model is "piezo"', '"servo", "transfer_function"'),
    ),
    Bad("unknown system", edit('"two_stage"', '"gantry"'), ('system is "gantry"', "two_stage")),
    Bad("unknown precision", edit("float64", "float16"), ('"float16"', '"float64" or "float32"')),
    Bad("name no C can have", edit('"small"', '"2 small"'), ('name is "2 small"', "C identifier")),
    Bad("name a keyword of C", edit('"small"', '"while"'), ('name is "while"', "C identifier")),
    Bad("name of a header of C", edit('"small"', '"math"'), ('name is "math"', "header")),
    Bad("name of the runtime's", edit('"small"', '"sg_pqp"'), ('name is "sg_pqp"', "sg_")),
    Bad("name too long", edit('"small"', f'"{"n" * 32}"'), ("name is", "at most 31 letters")),
    Bad("name not of ASCII", edit('"small"', '"größe"'), ("name is", "C identifier")),
    Bad(
        "iteration cap of zero",
        edit("[path]", "[controller.solver]\niteration_cap = 0\n[path]"),
        ("controller.solver.iteration_cap is 0", "from 1 to", '"target"'),
    ),
    Bad(
        "a solver that there is not",
        edit("[path]", '[controller]\nsolver = "osqp"\n[path]'),
        ('controller.solver is "osqp"', "[controller.solver]", '"pqp" or "active_set"'),
    ),
    Bad(
        "terminal weight below the Lyapunov solution",
        edit("horizon = 3", "horizon = 3\nterminal_weight = 0.5"),
        ("controller.mpc.terminal_weight is 0.5", '"lyapunov"', "at least 1"),
    ),
    Bad(
        "tightening of everything",
        edit("[path]", "[controller.governor]\nsteady_state_tightening = 1.0\n[path]"),
        ("controller.governor.steady_state_tightening is 1.0", "at most 0.5"),
    ),
    Bad(
        "layer feed of zero",
        edit("[output]", '[path.layer_feeds_m_per_s]\n"MY LAYER" = 0\n[output]'),
        ('path.layer_feeds_m_per_s."MY LAYER" is 0', "above 0"),
    ),
    Bad(
        "matrix with a text in it",
        slow_ss('[[0, 1], ["a", 2]]', "[1, 2]", "[1, 0]"),
        ('machine.x.slow.a[1][0] is "a"', "a finite number"),
    ),
    Bad(
        "coefficient that is no number",
        slow_tf("[1]", "[1, 3, nan, 1]"),
        ("machine.x.slow.denominator[2] is nan", "a finite number"),
    ),
    Bad("name of a file empty", edit('"line.dxf"', '""'), ('path.file is ""', ".dxf")),
)

CONTRADICTIONS = (
    Bad(
        "M no integer",
        edit("slow_sample_time_s = 0.03", "slow_sample_time_s = 0.0305"),
        ("sampling.slow_sample_time_s is 0.0305", "whole multiple", "0.001"),
    ),
    Bad(
        "M of one",
        edit("slow_sample_time_s = 0.03", "slow_sample_time_s = 0.001"),
        ("sampling.slow_sample_time_s is 0.001", "from 2"),
    ),
    Bad(
        "fast range beyond the slow one",
        edit("range_m = 0.035", "range_m = 0.5"),
        ("machine.x.fast.range_m is 0.5", "position_limit_m = 0.4"),
    ),
    Bad(
        "fast stage slower than the slow one",
        edit("= 2250.0", "= 40.0"),
        ("machine.x.fast.bandwidth_rad_per_s is 40.0", "more than", "45.0"),
    ),
    Bad(
        "fast stage weaker than the slow one",
        edit("= 49.05", "= 10.0"),
        ("machine.x.fast.acceleration_limit_m_per_s2 is 10.0", "14.71"),
    ),
    Bad(
        "path asks for more than the ideal machine has",
        edit("[output]", "centripetal_acceleration_m_per_s2 = 60\n[output]"),
        ("path.centripetal_acceleration_m_per_s2 is 60", "49.05"),
    ),
    Bad(
        "flattening coarser than the contour error allowed",
        edit("[output]", "tolerance_m = 1e-3\n[output]"),
        ("path.tolerance_m is 0.001", "target.contour_error_limit_m"),
    ),
    Bad(
        "margin finer than float32",
        both(
            edit("float64", "float32"),
            edit("[path]", "[controller.solver]\nconstraint_margin = 1e-7\n[path]"),
        ),
        ("controller.solver.constraint_margin is 1e-07", "1e-05", "float32"),
    ),
    Bad(
        "matrix not square",
        slow_ss("[[0, 1], [1]]", "[1, 2]", "[1, 0]"),
        ("machine.x.slow.a[1] is [1.0]", "2 numbers"),
    ),
    Bad(
        "input vector of another size",
        slow_ss("[[0, 1], [1, 1]]", "[1]", "[1, 0]"),
        ("machine.x.slow.b is [1.0]", "2 numbers"),
    ),
    Bad(
        "denominator that begins with zero",
        slow_tf("[1]", "[0, 1, 1, 1]"),
        ("machine.x.slow.denominator[0] is 0.0", "not zero"),
    ),
)

PLANTS = (
    Bad(
        "unstable transfer function",
        slow_tf("[-1000]", "[1, 30, 300, -1000]"),
        ("machine.x.slow.denominator", "unstable", "a stable stage"),
    ),
    Bad(
        "unstable state space",
        slow_ss("[[0, 1, 0], [0, 0, 1], [1000, -300, -30]]", "[0, 0, -1000]", "[1, 0, 0]"),
        ("machine.x.slow.a", "unstable", "a stable stage"),
    ),
    Bad(
        "dc gain of two",
        slow_tf("[2000]", "[1, 30, 300, 1000]"),
        ("machine.x.slow.denominator", "dc gain 2", "dc gain 1"),
    ),
    Bad(
        "relative degree two",
        slow_tf("[1, 1000]", "[1, 30, 300, 1000]"),
        ("machine.x.slow.numerator is [1.0, 1000.0]", "three more poles than zeros"),
    ),
    Bad(
        "second order",
        slow_tf("[100]", "[1, 20, 100]"),
        ("machine.x.slow.denominator is [1.0, 20.0, 100.0]", "third order"),
    ),
    Bad(
        "model slower by its transfer function",
        edit(
            'model = "servo"\nbandwidth_rad_per_s = 2250.0\ndamping = 0.7',
            'model = "transfer_function"\nnumerator = [1000]\ndenominator = [1, 30, 300, 1000]',
        ),
        ("machine.x.fast", "bandwidth", "faster than the slow one's"),
    ),
    Bad(
        "no model file",
        slow('model = "python"\nfile = "none.py"\nfunction = "stage"'),
        ("machine.x.slow.file", "none.py", "can be read"),
    ),
    Bad(
        "model file that fails",
        model_file("1/0\n"),
        ("machine.x.slow.file", "model.py", "ZeroDivisionError"),
    ),
    Bad(
        "model file without the function",
        model_file("", "stage"),
        ("machine.x.slow.function is stage", "a function of model.py"),
    ),
    Bad(
        "model function that returns something else",
        model_file("def stage():\n    return 3\n"),
        ("machine.x.slow.function", "returning int"),
    ),
)

PATHS = (
    Bad("no drawing", edit("line.dxf", "none.dxf"), ("drawing",), "none.dxf"),
    Bad("drawing of another kind", drawing("a.pdf", "x"), ("path.file is", "a.pdf", ".dxf")),
    Bad("empty drawing", drawing("a.dxf", ""), ("drawing is empty",), "a.dxf"),
    Bad("drawing with nothing in it", drawing("a.dxf", dxf()), ("drawing", "at least"), "a.dxf"),
    Bad("broken drawing", drawing("a.dxf", "0\nSECTION\nhello\n"), ("broken",), "a.dxf"),
    Bad(
        "entity of no length",
        drawing("a.dxf", dxf(line(1, 1, 1, 1))),
        ("LINE", "length zero"),
        "a.dxf",
    ),
    Bad(
        "arc of negative radius",
        drawing("a.dxf", dxf("ARC 8 0 10 0.0 20 0.0 40 -5.0 50 0.0 51 90.0")),
        ("ARC", "radius"),
        "a.dxf",
    ),
    Bad(
        "coordinate that is no number",
        drawing("a.dxf", dxf("LINE 8 0 10 nan 20 0.0 11 1.0 21 1.0")),
        ("LINE", "finite"),
        "a.dxf",
    ),
    Bad(
        "entity that is no path",
        drawing("a.dxf", dxf("TEXT 8 0 10 0.0 20 0.0 40 2.5 1 hello")),
        ("TEXT", "not supported"),
        "a.dxf",
    ),
    Bad("drawing cut off", drawing("a.dxf", dxf(line(0, 0, 1, 1))[:-12]), ("broken",), "a.dxf"),
    Bad(
        "line without an end",
        drawing("a.dxf", dxf("LINE 8 0 10 1.0 20 1.0")),
        ("LINE #", "without its end", "a complete LINE"),
        "a.dxf",
    ),
    Bad(
        "drawing in an unknown unit",
        drawing("a.dxf", dxf(line(0, 0, 1, 1)).replace("70\n4", "70\n3")),
        ("$INSUNITS is 3", "4 (mm)"),
        "a.dxf",
    ),
    Bad(
        "drawing a thousand times too large",
        drawing("a.dxf", dxf(line(0, 0, 2e6, 0))),
        ("LINE #", "2000 m from the origin", "1000 m"),
        "a.dxf",
    ),
    Bad("binary drawing", drawing("a.dxf", bytes(range(256))), ("broken",), "a.dxf"),
    Bad("SVG cut off", drawing("a.svg", svg('<line x2="9"/>')[:-4]), ("line 1", "broken"), "a.svg"),
    Bad("SVG without shapes", drawing("a.svg", svg("<g/>")), ("drawing", "at least"), "a.svg"),
    Bad(
        "SVG with writing in it",
        drawing("a.svg", svg('<text id="t9">part 7</text>')),
        ("text #t9", "not supported", "one of path"),
        "a.svg",
    ),
    Bad(
        "SVG in lengths of no size",
        drawing("a.svg", svg('<circle r="2em"/>')),
        ("circle 1", 'r="2em"', "a length"),
        "a.svg",
    ),
    Bad(
        "SVG with broken path data",
        drawing("a.svg", svg('<path d="M 0 0 L 5"/>')),
        ("path 1", "broken path data"),
        "a.svg",
    ),
    Bad(
        "SVG with a hidden shape",
        drawing("a.svg", svg('<line x2="9" style="display:none"/>')),
        ("line 1", "hidden", "a visible element"),
        "a.svg",
    ),
    Bad(
        "part program that moves z with two axes",
        drawing("a.nc", "G21\nG0 X1\nG1 Z-5 F100\n"),
        ("line 3 is a move of z to -0.005 m", "a level path: there are two axes"),
        "a.nc",
    ),
    Bad(
        "G-code that is not supported",
        drawing("a.gcode", "G1 X1\nG41\n"),
        ("line 2 is G41", "one of G0 G1"),
        "a.gcode",
    ),
    Bad(
        "G-code arc of two radii",
        drawing("a.ngc", "G2 X10 I4 J0\n"),
        ("line 1", "4 mm at its start", "6 mm at its end"),
        "a.ngc",
    ),
    Bad(
        "G-code arc too small",
        drawing("a.nc", "G3 X10 R4\n"),
        ("line 1", "radius 4 mm", "at least 5 mm"),
        "a.nc",
    ),
    Bad("G-code that is a letter", drawing("a.nc", "Dear sirs,\n"), ("line 1", "DEARSIRS"), "a.nc"),
    Bad("CSV with NaN", drawing("a.csv", "0,0\n0.1,nan\n"), ("line 2: y_m", '"nan"'), "a.csv"),
    Bad(
        "CSV with a ragged row",
        drawing("a.csv", "x_m,y_m\n0,0\n0.1\n"),
        ("line 3", "1 column", "expected 2"),
        "a.csv",
    ),
    Bad(
        "CSV in millimetres",
        drawing("a.csv", "x_mm,y_mm\n0,0\n10,0\n"),
        ("line 1", "x_mm,y_mm", "x_m,y_m"),
        "a.csv",
    ),
    Bad(
        "feeds of layers in a file without layers",
        both(
            drawing("a.csv", "0,0\n0.1,0\n"),
            edit("[output]", "[path.layer_feeds_m_per_s]\nCUT = 0.1\n[output]"),
        ),
        ("path.layer_feeds_m_per_s.CUT", "no layers"),
    ),
    Bad(
        "layer that the drawing lacks",
        edit("[output]", "[path.layer_feeds_m_per_s]\nCUT = 0.1\n[output]"),
        ("path.layer_feeds_m_per_s.CUT", "a layer of line.dxf"),
    ),
    Bad(
        "path out of the workspace",
        drawing("a.dxf", dxf(line(380, 0, 410, 0))),
        ("point ", "(0.396", "LINE", "outside the workspace", "below 0.396 m"),
        "a.dxf",
    ),
    Bad(
        "step that breaks Theorem 1's hypothesis",
        both(
            edit("fast_sample_time_s = 0.001", "fast_sample_time_s = 0.015"),
            edit("acceleration_limit_m_per_s2 = 14.71", "acceleration_limit_m_per_s2 = 0.5"),
        ),
        ("point ", "LINE", "Theorem 1", "acceleration", "mm along x"),
        "line.dxf",
    ),
    Bad(
        "feed so low that the path never ends",
        edit("feed_m_per_s = 0.2", "feed_m_per_s = 1e-9"),
        ("path.feed_m_per_s", "points"),
    ),
)


def target(old: str, new: str) -> Change:
    """A target of the user's own, a bundled one in which a text is replaced."""

    def change(toml: Path) -> None:
        bundled = Path(servogen.wcet.targets.__file__).parent / "targets" / "generic.toml"
        text = bundled.read_text()
        assert old in text
        (toml.parent / "mine.toml").write_text(text.replace(old, new, 1))
        edit("[output]", '[target]\nname = "mine.toml"\n[output]')(toml)

    return change


TARGETS = (
    Bad(
        "unknown target",
        edit("[output]", '[target]\nname = "z80"\n[output]'),
        ("target.name is z80", "tms320c6678", "or a TOML file"),
    ),
    Bad(
        "target without cycles for the precision",
        edit("[output]", '[target]\nname = "tms320vc33"\n[output]'),
        ('output.precision is "float64"', '"float32"', "tms320vc33"),
    ),
    Bad(
        "target without a clock",
        target("clock_hz", "clock_mhz"),
        ("clock_mhz is unknown", "one of", "clock_hz"),
        "mine.toml",
    ),
    Bad("target that is no TOML", target("clock_hz", "clock_hz ="), ("TOML",), "mine.toml"),
)

ALL = (*TARGETS, *FORMAT, *KEYS, *VALUES, *CONTRADICTIONS, *PLANTS, *PATHS)
