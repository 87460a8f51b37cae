"""The verbs of the command line.

Exit status: 0 all well, 1 a check failed, 2 the input was wrong, 3 a check could not run for want
of a tool, 70 a fault of servogen's own, 130 interrupted. A fault is one line on standard error;
results go to standard output.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, NoReturn, Protocol, TextIO

import typer

from servogen import __version__
from servogen.errors import InputError, ServogenError
from servogen.jsontext import json_text
from servogen.outputs import check_file, check_tree, write_file

CHECK_FAILED, WRONG_INPUT, INTERNAL_ERROR, INTERRUPTED, BROKEN_PIPE = 1, 2, 70, 130, 141

app = typer.Typer(
    name="servogen",
    help="From a machine model and a drawing to proven, counted C99 motion controllers.",
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

Toml = Annotated[Path, typer.Argument(metavar="TOML", help="The project file.", show_default=False)]
Json = Annotated[
    Path | None,
    typer.Option("--json", metavar="FILE", help="Write the result as JSON, - for stdout."),
]


class Result(Protocol):
    """What every step of the pipeline returns."""

    @property
    def passed(self) -> bool:
        """Whether every check of the step held."""

    def lines(self) -> list[str]:
        """The summary for a person."""

    def to_json(self) -> Mapping[str, object]:
        """The summary for a program, see docs/json.md."""


def _version(wanted: bool) -> None:
    if wanted:
        print(f"servogen {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Say the version.")
    ] = False,
) -> None:
    """Options before the verb."""


@app.command()
def init(
    system: Annotated[
        str,
        typer.Argument(
            help="two_stage, servo_drive, command_governor or contour_lq.", show_default=False
        ),
    ],
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="A new or empty folder.", show_default=False)
    ],
) -> None:
    """Copy an example, project file and what belongs to it, ready to edit."""
    from servogen.scaffold import copy_example

    project = copy_example(system, folder)
    print(f"{project} is ready to edit; then: servogen run {project}")


@app.command()
def build(
    toml: Toml,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="OUT", help="Default: build/ beside TOML."),
    ] = None,
) -> None:
    """Emit the C of the project's controller."""
    folder = toml.parent / "build" if out is None else out
    _run_step("build", toml, None, folder, place=lambda: check_tree(folder))


@app.command()
def sil(
    toml: Toml,
    steps: Annotated[
        str | None,
        typer.Option(metavar="N", help="Periods of each closed loop to compare. Default: all."),
    ] = None,
    json: Json = None,
) -> None:
    """Compile the C and prove it equal to the reference."""
    _run_step("sil", toml, json, steps=None if steps is None else _count("--steps", steps))


@app.command()
def wcet(
    toml: Toml,
    target: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="A bundled target or a TOML. Default: the project's."),
    ] = None,
    all_targets: Annotated[
        bool,
        typer.Option("--all-targets", help="Show every bundled target; the status is as without."),
    ] = False,
    json: Json = None,
) -> None:
    """Count the operations of the C and fit them to a target's period and memory."""
    _run_step("wcet", toml, json, target=target, all_targets=all_targets)


@app.command()
def simulate(
    toml: Toml,
    reference: Annotated[
        bool, typer.Option("--reference", help="Run the Python reference, not the C.")
    ] = False,
    json: Json = None,
) -> None:
    """Run the project's task in closed loop and check its constraints."""
    _run_step("simulate", toml, json, reference=reference)


@app.command()
def study(toml: Toml, json: Json = None) -> None:
    """Make the paper's comparison on this machine."""
    _run_step("study", toml, json)


@app.command()
def check(
    name: Annotated[str, typer.Argument(metavar="CHECK", help="See servogen check list.")],
    toml: Annotated[Path | None, typer.Argument(metavar="TOML", help="The project file.")] = None,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="OUT", help="Default: out/ beside TOML."),
    ] = None,
    json: Json = None,
) -> None:
    """Examine the emitted C with one of the outside tools and keep the finding in OUT/evidence."""
    from servogen.evidence.catalogue import CHECKS
    from servogen.steps.check import titles

    known = titles()
    if name == "list":
        for each, title in known.items():
            needs = CHECKS[each].needs if each in CHECKS else ()
            wants = f" (apt-get install {' '.join(needs)})" if needs else ""
            print(f"{each:<11} {title}{wants}")
        return
    if name not in known:
        raise InputError(None, "CHECK", name, f"one of list, {', '.join(known)}")
    if toml is None:
        raise InputError(None, "TOML", "missing", "the project file after the name of the check")
    folder = toml.parent / "out" if out is None else out
    _run_step("check", toml, json, name, folder)


@app.command()
def certificate(
    toml: Toml,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="OUT", help="Default: out/ beside TOML."),
    ] = None,
    json: Json = None,
) -> None:
    """Gather what the checks found about this build into OUT/certificate.json."""
    _run_step("certificate", toml, json, toml.parent / "out" if out is None else out)


@app.command()
def report(
    toml: Toml,
    out: Annotated[
        Path, typer.Option("-o", "--out", metavar="FILE", help="The HTML file to write.")
    ],
) -> None:
    """Write the report, one HTML file with everything in it."""
    _run_step("report", toml, None, out, place=lambda: check_file(out))


@app.command()
def run(
    toml: Toml,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="OUT", help="Default: out/ beside TOML."),
    ] = None,
) -> None:
    """All of it in order: build, proofs, sil, wcet, simulate, study, report."""
    folder = toml.parent / "out" if out is None else out
    _run_step("run", toml, None, folder, place=lambda: check_tree(folder / "c"))


def _run_step(
    verb: str,
    toml: Path,
    json: Path | None,
    *args: object,
    place: Callable[[], None] | None = None,
    **options: object,
) -> None:
    """Load the project, do the step, tell, and set the status.

    What costs seconds to import is imported here, after the project file has been found well.
    """
    from servogen.project.systems import load_any_project

    project = load_any_project(toml)
    # Before the work, so that a mistyped place costs a second and not minutes.
    if place is not None:
        place()
    if json is not None and str(json) != "-":
        check_file(json)
    from servogen import pipeline
    from servogen.progress import for_stream

    step: Callable[..., Result] = getattr(pipeline, verb)
    result = step(project, *args, **options, progress=for_stream(sys.stderr))
    # With the JSON on standard output, the lines for people step aside.
    people = sys.stderr if json is not None and str(json) == "-" else sys.stdout
    for line in result.lines():
        print(line, file=people)
    if json is not None:
        _hand_out(json, result.to_json())
    if not result.passed:
        raise typer.Exit(CHECK_FAILED)


def _count(option: str, text: str) -> int:
    """A whole number above zero; typer's own message would not say what stood there."""
    if not (text.isascii() and text.isdigit() and 0 < len(text) < 19 and int(text) > 0):
        raise InputError(None, option, text, "a whole number at least 1")
    return int(text)


def _hand_out(place: Path, data: Mapping[str, Any]) -> None:
    if str(place) == "-":
        sys.stdout.write(json_text(data))
    else:
        write_file(place, json_text(data))


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit status and never raises what a user could cause."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    for stream in (sys.stdout, sys.stderr):
        _never_fail_on_a_character(stream)
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, _interrupt)  # a polite kill cleans up as Ctrl-C does
    try:
        status = int(app(arguments or ["--help"], standalone_mode=False) or 0)
        if status == INTERRUPTED:  # some versions of typer answer Ctrl-C with the status alone
            raise KeyboardInterrupt
        sys.stdout.flush()
    except ServogenError as error:
        return _fail(str(error), error.exit_status)
    except (KeyboardInterrupt, typer.Abort):
        return _fail("interrupted", INTERRUPTED)
    except BrokenPipeError:  # "servogen ... | head": the reader has enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE
    except Exception as error:
        return _fail_unexpectedly(error)
    return status if arguments else WRONG_INPUT


def _interrupt(number: int, frame: object) -> NoReturn:
    raise KeyboardInterrupt


def _fail_unexpectedly(error: Exception) -> int:
    format_message = getattr(error, "format_message", None)
    if format_message is not None:  # typer's own errors of usage; their base is not public
        return _fail(f"{format_message()} (servogen --help)", WRONG_INPUT)
    if os.environ.get("SERVOGEN_TRACEBACK") == "1":
        traceback.print_exception(error)
    told = f"internal error: {type(error).__name__}: {error}; please report it"
    return _fail(f"{told}; SERVOGEN_TRACEBACK=1 shows where it happened", INTERNAL_ERROR)


def _fail(message: str, status: int) -> int:
    """One line on standard error, whatever the message has in it."""
    line = "".join(c if c.isprintable() else " " for c in message)
    print(f"servogen: {line}", file=sys.stderr)
    return status


def _never_fail_on_a_character(stream: TextIO) -> None:
    reconfigure = getattr(stream, "reconfigure", None)
    if reconfigure is not None:
        reconfigure(errors="replace")


if __name__ == "__main__":
    sys.exit(main())
