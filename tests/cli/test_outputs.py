"""Outputs are whole or not there, and nothing but servogen's own is replaced."""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Callable
from pathlib import Path

import pytest

from servogen import outputs
from servogen.errors import InputError
from servogen.jsontext import json_text
from servogen.outputs import check_file, check_tree, write_file, write_tree

OURS = '{"schema": "servogen.manifest/1"}'
NEW = {"manifest.json": OURS, "src/a.c": "int a;\n", "b.bin": b"\x00\r\n"}


def tree(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def as_bytes(files: dict[str, str | bytes]) -> dict[str, bytes]:
    return {name: data.encode() if isinstance(data, str) else data for name, data in files.items()}


def interrupt_after(calls: int, function: Callable[..., object]) -> Callable[..., object]:
    """The function, with Ctrl-C arriving at its call of this number."""
    left = [calls]

    def interrupted(*args: object, **kwargs: object) -> object:
        left[0] -= 1
        if left[0] < 0:
            left[0] = 10**9  # Ctrl-C comes once; what cleans up after it works again
            raise KeyboardInterrupt
        return function(*args, **kwargs)

    return interrupted


@pytest.mark.parametrize("out", ["new", "deep/er/new", "empty", "old"])
def test_a_tree_holds_exactly_the_files_given(tmp_path: Path, out: str) -> None:
    (tmp_path / "empty").mkdir()
    write_tree(tmp_path / "old", {"manifest.json": OURS, "gone/x.c": "old", "b.bin": "old"})
    write_tree(tmp_path / out, NEW)
    assert tree(tmp_path / out) == as_bytes(NEW)
    assert not (tmp_path / out / "gone").exists()
    assert not list(tmp_path.rglob(".servogen*"))


def test_new_files_and_folders_have_the_usual_permissions(tmp_path: Path) -> None:
    (tmp_path / "usual").mkdir()
    (tmp_path / "usual" / "file").touch()
    write_tree(tmp_path / "new", {"file": ""})
    write_file(tmp_path / "one", "")
    for ours, usual in (("new", "usual"), ("new/file", "usual/file"), ("one", "usual/file")):
        modes = {stat.S_IMODE((tmp_path / name).stat().st_mode) for name in (ours, usual)}
        assert len(modes) == 1


@pytest.mark.parametrize(
    ("exists", "name", "calls"),
    [(True, "_write", 1), (True, "rename", 1), (False, "_write", 1), (False, "rename", 0)],
)
def test_ctrl_c_leaves_the_old_tree(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, exists: bool, name: str, calls: int
) -> None:
    out = tmp_path / "deep" / "out"
    old = {"manifest.json": OURS, "x/old.c": "old", "b.bin": "old"}
    if exists:
        write_tree(out, old)
    place = outputs if name == "_write" else os
    monkeypatch.setattr(place, name, interrupt_after(calls, getattr(place, name)))
    with pytest.raises(KeyboardInterrupt):
        write_tree(out, NEW)
    assert tree(tmp_path) == (
        {f"deep/out/{name}": data for name, data in as_bytes(old).items()} if exists else {}
    )
    assert exists or list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("calls", range(6))
def test_ctrl_c_anywhere_in_the_exchange_leaves_old_or_new(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, calls: int
) -> None:
    out = tmp_path / "out"
    old = {"manifest.json": OURS, "x/old.c": "old", "b.bin": "old"}
    write_tree(out, old)
    monkeypatch.setattr(os, "rename", interrupt_after(calls, os.rename))
    with pytest.raises(KeyboardInterrupt):
        write_tree(out, NEW)
    assert tree(tmp_path) == {f"out/{name}": data for name, data in as_bytes(old).items()}


@pytest.mark.parametrize("function", ["_write", "replace"])
def test_ctrl_c_leaves_the_old_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, function: str
) -> None:
    (tmp_path / "result.json").write_text("old")
    place = outputs if function == "_write" else os
    monkeypatch.setattr(place, function, interrupt_after(0, getattr(place, function)))
    with pytest.raises(KeyboardInterrupt):
        write_file(tmp_path / "result.json", "new")
    assert tree(tmp_path) == {"result.json": b"old"}


def test_a_full_disk_is_told_and_leaves_the_old_tree(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_tree(tmp_path / "out", {"manifest.json": OURS})

    def full(path: Path, data: object) -> None:
        raise OSError(28, os.strerror(28))

    monkeypatch.setattr(outputs, "_write", full)
    with pytest.raises(InputError, match="No space left on device"):
        write_tree(tmp_path / "out", NEW)
    assert tree(tmp_path) == {"out/manifest.json": OURS.encode()}


@pytest.mark.parametrize(
    ("files", "says"),
    [
        ({"notes.txt": "mine"}, "no manifest.json"),
        ({"manifest.json": "{"}, "no manifest.json"),
        ({"manifest.json": "[1]"}, "not servogen's"),
        ({"manifest.json": '{"name": "a browser extension"}'}, "not servogen's"),
        ({"manifest.json": '{"schema": "other.servogen."}'}, "not servogen's"),
        ({"manifest.json": '{"schema": 3}'}, "not servogen's"),
        (
            {"manifest.json": '{"schema": "servogen.manifest/1", "files": []}', "main.c": ""},
            "main.c",
        ),
        (
            {
                "manifest.json": '{"schema": "servogen.manifest/1", "files": {"a.c": {}}}',
                "d/a.c": "",
            },
            "d/a.c",
        ),
    ],
)
def test_what_servogen_did_not_make_is_left_alone(
    tmp_path: Path, files: dict[str, str], says: str
) -> None:
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    for act in (lambda: write_tree(tmp_path, NEW), lambda: check_tree(tmp_path)):
        with pytest.raises(InputError, match=says):
            act()
    assert tree(tmp_path) == as_bytes(dict(files))


def test_a_listed_tree_is_replaced_and_a_kill_s_leftovers_cleared(tmp_path: Path) -> None:
    listed = {"schema": "servogen.manifest/1", "files": {"src/a.c": {"sha256": ""}}}
    write_tree(tmp_path, {"manifest.json": json.dumps(listed), "src/a.c": ""})
    (tmp_path / ".servogen-tmp-0123456789ab" / "new").mkdir(parents=True)
    (tmp_path / ".servogen-tmp-0123456789ab" / "new" / "half.c").touch()
    write_tree(tmp_path, NEW)
    assert tree(tmp_path) == as_bytes(NEW)
    assert not list(tmp_path.glob(".servogen*"))


@pytest.mark.parametrize("name", ["/etc/x", "../x", "a/../../x", ""])
def test_no_name_leads_out_of_the_tree(tmp_path: Path, name: str) -> None:
    with pytest.raises(ValueError, match="not a name inside"):
        write_tree(tmp_path / "out", {name: ""})
    assert list(tmp_path.iterdir()) == []


def test_links_stay_links(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "real.json").write_text("old")
    (tmp_path / "link").symlink_to("real")
    (tmp_path / "link.json").symlink_to("real.json")
    write_tree(tmp_path / "link", NEW)
    write_file(tmp_path / "link.json", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "link.json").is_symlink()
    assert tree(tmp_path / "real") == as_bytes(NEW)
    assert (tmp_path / "real.json").read_text() == "new"


def test_a_device_is_written_into_and_not_replaced(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    check_file(pipe)
    write_file(pipe, "told")
    assert os.read(reader, 100) == b"told"
    os.close(reader)
    assert stat.S_ISFIFO(pipe.stat().st_mode)


def test_checks_leave_no_trace(tmp_path: Path) -> None:
    check_file(tmp_path / "a" / "b.json")
    check_tree(tmp_path / "c" / "d")
    check_tree(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_json_text_is_strict_json_in_the_order_given() -> None:
    import numpy as np

    data = {
        "schema": "servogen.x/1",
        "b": np.float64(0.5),
        "a": np.array([[1, 2], [3, 4]]),
        "n": [np.inf, float("nan"), np.int64(3), True, None, "µ"],
    }
    text = json_text(data)
    parsed = json.loads(text, parse_constant=lambda name: pytest.fail(name))
    assert list(parsed) == ["schema", "b", "a", "n"]
    assert parsed["a"] == [[1, 2], [3, 4]]
    assert parsed["n"] == [None, None, 3, True, None, "µ"]
    assert text.endswith("}\n")
