"""The verbs: what they call, what they print, and the status they end with."""

from __future__ import annotations

import json
import subprocess
import sys
import types
from collections.abc import Callable
from pathlib import Path

import pytest
from small_project import FakeResult, Outcome

from servogen import __version__
from servogen.errors import CheckFailed
from servogen.project import Project

Command = Callable[..., Outcome]
VERBS = ("build", "sil", "wcet", "simulate", "study", "report", "run")


def recorded(fake: types.SimpleNamespace, verb: str, result: FakeResult) -> list[tuple]:
    """Make a step of the pipeline return ``result``; the calls it gets."""
    calls: list[tuple] = []

    def step(project: Project, *args: object, **options: object) -> FakeResult:
        options.pop("progress").task  # noqa: B018  a Progress comes along
        calls.append((project.name, args, options))
        return result

    setattr(fake, verb, step)
    return calls


@pytest.mark.parametrize(
    ("arguments", "args", "options"),
    [
        (("build",), ("build",), {}),
        (("build", "-o", "there"), ("there",), {}),
        (("sil",), (), {"steps": None}),
        (("sil", "--steps", "7"), (), {"steps": 7}),
        (("wcet",), (), {"target": None, "all_targets": False}),
        (("wcet", "--target", "m7"), (), {"target": "m7", "all_targets": False}),
        (("simulate",), (), {"reference": False}),
        (("simulate", "--reference"), (), {"reference": True}),
        (("study",), (), {}),
        (("report", "-o", "report.html"), ("report.html",), {}),
        (("run",), ("out",), {}),
        (("run", "-o", "there"), ("there",), {}),
        (("certificate",), ("out",), {}),
        (("certificate", "-o", "there"), ("there",), {}),
    ],
)
def test_verbs_call_their_step(
    arguments: tuple[str, ...],
    args: tuple[str, ...],
    options: dict[str, object],
    small: Path,
    servogen_command: Command,
    fake_pipeline: types.SimpleNamespace,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(small.parent)
    calls = recorded(fake_pipeline, arguments[0], FakeResult(told=["one", "two"]))
    outcome = servogen_command(arguments[0], small.name, *arguments[1:])
    assert outcome == Outcome(0, "one\ntwo\n", "")
    assert calls == [("small", tuple(Path(arg) for arg in args), options)]


def test_a_check_gets_its_name_and_the_folder_of_the_evidence(
    small: Path, servogen_command: Command, fake_pipeline: types.SimpleNamespace
) -> None:
    calls = recorded(fake_pipeline, "check", FakeResult(told=["equal"]))
    assert servogen_command("check", "pil", small) == Outcome(0, "equal\n", "")
    assert servogen_command("check", "pil", small, "-o", "there").status == 0
    assert [c[1] for c in calls] == [("pil", small.parent / "out"), ("pil", Path("there"))]


def test_the_list_of_checks_names_what_each_wants(servogen_command: Command) -> None:
    outcome = servogen_command("check", "list")
    assert outcome.status == 0
    lines = {line.split()[0]: line for line in outcome.out.splitlines()}
    assert "apt-get install" in lines["pil"]
    assert "qemu-system-arm" in lines["pil"]
    assert "apt-get" not in lines["sil"]
    assert set(lines) >= {"sets", "terminal", "wcet", "misra", "prove", "dsp", "coverage", "fuzz"}


@pytest.mark.parametrize("arguments", [("nonsense",), ("nonsense", "p.toml"), ("pil",)])
def test_a_check_that_is_none_or_has_no_project(
    arguments: tuple[str, ...], servogen_command: Command
) -> None:
    outcome = servogen_command("check", *arguments)
    assert outcome.status == 2
    assert "expected" in outcome.err
    assert outcome.err.count("\n") == 1


def test_default_folders_stand_beside_the_project_file(
    small: Path, servogen_command: Command, fake_pipeline: types.SimpleNamespace
) -> None:
    calls = recorded(fake_pipeline, "run", FakeResult())
    servogen_command("run", small)
    assert calls[0][1] == (small.parent / "out",)


def test_a_failed_check_is_status_1(
    small: Path, servogen_command: Command, fake_pipeline: types.SimpleNamespace
) -> None:
    recorded(fake_pipeline, "sil", FakeResult(passed=False, told=["3 mismatches"]))
    assert servogen_command("sil", small) == Outcome(1, "3 mismatches\n", "")


@pytest.mark.parametrize("verb", ["sil", "wcet", "simulate", "study"])
def test_json_goes_to_a_file_even_when_a_check_failed(
    verb: str, small: Path, servogen_command: Command, fake_pipeline: types.SimpleNamespace
) -> None:
    data = {"schema": f"servogen.{verb}/1", "ratio": 1.25, "worst": float("nan")}
    recorded(fake_pipeline, verb, FakeResult(passed=False, data=data))
    place = small.parent / "deep" / "result.json"
    assert servogen_command(verb, small, "--json", place).status == 1
    assert json.loads(place.read_text()) == {**data, "worst": None}
    assert list(json.loads(place.read_text())) == list(data)


def test_json_on_standard_output_is_alone_there(
    small: Path, servogen_command: Command, fake_pipeline: types.SimpleNamespace
) -> None:
    recorded(fake_pipeline, "wcet", FakeResult(told=["fits"], data={"schema": "servogen.wcet/1"}))
    outcome = servogen_command("wcet", small, "--json", "-")
    assert json.loads(outcome.out) == {"schema": "servogen.wcet/1"}
    assert outcome.err == "fits\n"


@pytest.mark.parametrize(
    ("error", "status", "says"),
    [
        (CheckFailed("the budget\nis exceeded"), 1, "servogen: the budget is exceeded\n"),
        (KeyboardInterrupt(), 130, "servogen: interrupted\n"),
        (RuntimeError("oh"), 70, "servogen: internal error: RuntimeError: oh; please report it"),
    ],
)
def test_other_endings_are_one_line(
    error: BaseException,
    status: int,
    says: str,
    small: Path,
    servogen_command: Command,
    fake_pipeline: types.SimpleNamespace,
) -> None:
    def study(project: Project, progress: object) -> FakeResult:
        raise error

    fake_pipeline.study = study
    outcome = servogen_command("study", small)
    assert outcome.status == status
    assert outcome.err.startswith(says)
    assert outcome.err.count("\n") == 1


def test_the_traceback_of_an_internal_error_is_there_when_asked_for(
    small: Path,
    servogen_command: Command,
    fake_pipeline: types.SimpleNamespace,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("SERVOGEN_TRACEBACK", "1")
    fake_pipeline.study = None
    outcome = servogen_command("study", small)
    assert outcome.status == 70
    assert "Traceback" in outcome.err


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("bild", "x.toml"), ("'bild'", "'build'")),
        (("build",), ("TOML",)),
        (("report", "x.toml"), ("--out",)),
        (("sil", "x.toml", "--steps", "0"), ("--steps is 0", "at least 1")),
        (("sil", "x.toml", "--steps", "many"), ("--steps", "many")),
        (("sil", "x.toml", "--stepz", "3"), ("--stepz",)),
        (("build", "one.toml", "two.toml"), ("two.toml",)),
        (
            ("init", "gantry", "there"),
            ("SYSTEM is gantry", "one of command_governor, contour_lq, servo_drive, two_stage"),
        ),
        (("init", "../two_stage", "there"), ("SYSTEM is ../two_stage",)),
    ],
)
def test_wrong_arguments_are_one_line_and_status_2(
    arguments: tuple[str, ...],
    says: tuple[str, ...],
    servogen_command: Command,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    outcome = servogen_command(*arguments)
    assert outcome.status == 2
    assert outcome.err.count("\n") == 1
    for fragment in says:
        assert fragment in outcome.err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("verb", "option", "place", "says"),
    [
        ("build", "-o", "servogen.toml", ("servogen.toml", "is a file", "a folder")),
        ("build", "-o", "servogen.toml/below", ("below", "is not a directory")),
        ("build", "-o", "full", ("full", "not servogen's to replace", "no manifest.json")),
        ("build", "-o", "n" * 300, ("not writable", "too long")),
        ("build", "-o", "/proc/none/here", ("/proc/none/here", "not writable")),
        ("sil", "--json", "full", ("full", "is a folder", "the name of a file")),
        ("sil", "--json", "line.dxf/x.json", ("x.json", "is not a directory")),
        ("report", "-o", "full", ("full", "is a folder", "the name of a file")),
        ("run", "-o", "servogen.toml", ("servogen.toml is not a directory",)),
        ("run", "-o", "full", ("full/c", "not servogen's to replace")),
    ],
)
def test_a_place_that_cannot_be_written_is_found_before_the_work(
    verb: str,
    option: str,
    place: str,
    says: tuple[str, ...],
    small: Path,
    servogen_command: Command,
    fake_pipeline: types.SimpleNamespace,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(small.parent)
    (small.parent / "full" / "c").mkdir(parents=True)
    (small.parent / "full" / "c" / "mine.txt").write_text("mine")
    before = sorted(small.parent.rglob("*"))
    calls = recorded(fake_pipeline, verb, FakeResult())
    outcome = servogen_command(verb, small.name, option, place)
    assert (outcome.status, outcome.out, calls) == (2, "", [])
    assert outcome.err.count("\n") == 1
    for fragment in says:
        assert fragment in outcome.err
    assert sorted(small.parent.rglob("*")) == before


def test_init_gives_a_project_that_is_a_good_one(tmp_path: Path, servogen_command: Command) -> None:
    from servogen.project import load_project

    outcome = servogen_command("init", "two_stage", tmp_path / "mine")
    assert (outcome.status, outcome.err) == (0, "")
    project = load_project(tmp_path / "mine" / "servogen.toml")
    assert project.sampling.ratio == 150
    assert project.path.file.is_file()
    assert not list((tmp_path / "mine").glob("make_*"))


def test_init_leaves_a_folder_with_something_in_it_alone(
    tmp_path: Path, servogen_command: Command
) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    outcome = servogen_command("init", "two_stage", tmp_path)
    assert outcome.status == 2
    assert "not empty" in outcome.err
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


def test_init_into_the_folder_one_stands_in(
    tmp_path: Path, servogen_command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert servogen_command("init", "two_stage", ".").status == 0
    assert Path("servogen.toml").is_file()  # by the working directory, not by its name


def test_version_and_help(servogen_command: Command) -> None:
    assert servogen_command("--version") == Outcome(0, f"servogen {__version__}\n", "")
    told = servogen_command("--help")
    assert told.status == 0
    assert all(verb in told.out for verb in ("init", *VERBS))
    assert servogen_command().status == 2


def test_help_does_not_import_what_is_slow() -> None:
    code = (
        "import sys; from servogen.cli import main; main(['--help']); "
        "sys.exit(any(name in sys.modules for name in ('numpy', 'scipy', 'casadi', 'pydantic')))"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True).returncode == 0


def test_a_reader_that_has_enough_is_no_internal_error() -> None:
    script = f'"{sys.executable}" -m servogen.cli --help | head -n 1; exit ${{PIPESTATUS[0]}}'
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True)
    assert "error" not in done.stderr
