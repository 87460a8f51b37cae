"""DXF drawings to strokes, in metres, entity by entity in drawing order."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import ezdxf

from servogen.errors import InputError
from servogen.paths.curves import Stroke
from servogen.paths.dxf_entities import check_supported, entity_segments
from servogen.paths.settings import PathSettings

# $INSUNITS codes; 0 (unitless, or no header) is taken as millimetres.
_METRES_PER_UNIT = {
    0: 1e-3,
    1: 0.0254,
    2: 0.3048,
    4: 1e-3,
    5: 1e-2,
    6: 1.0,
    8: 0.0254e-6,
    9: 0.0254e-3,
    10: 0.9144,
    13: 1e-6,
    14: 0.1,
}
_MOST_COPIES = 10_000
_DEEPEST = 100


def read_dxf(file: Path, settings: PathSettings) -> list[Stroke]:
    """Strokes of a DXF drawing's model space, blocks exploded; paper space is not read.

    Raises:
        InputError: the file is unreadable or corrupt, its unit is unknown, or it holds an entity
            that has no place in a flat tool path; entities are named by type and handle.
    """
    document, has_unit = _open(file)
    scale = _metres_per_unit(document, file) if has_unit else _METRES_PER_UNIT[0]
    strokes: list[Stroke] = []
    with _broken(file, "drawing", "a valid DXF file"):
        feeds = _layer_feeds(document, file, settings)
        for entity, handle, layer in _Exploder(file).flat(document.modelspace()):
            label = f"{entity.dxftype()} #{handle}"
            _check_visible(document, entity, label, layer, file)
            with _broken(file, label, f"a valid {entity.dxftype()}"):
                segments = entity_segments(entity, scale, label, file)
            strokes.append(Stroke(label, tuple(segments), feeds.get(layer.lower())))
    return strokes


@contextmanager
def _broken(file: Path, key: str, expected: str) -> Iterator[None]:
    """What ezdxf and the mathematics say of nonsense, as an error of the input."""
    try:
        yield
    except (
        ezdxf.DXFError,
        ValueError,
        ArithmeticError,
        AttributeError,
        LookupError,
        TypeError,
    ) as error:
        reason = " ".join(str(error).split()).rstrip(".")[:100] or type(error).__name__
        raise InputError(file, key, f"broken ({reason})", expected) from error


def _check_visible(document: Any, entity: Any, label: str, layer: str, file: Path) -> None:
    """Hidden entities are refused: whether they are to be cut is for the user to say."""
    if document.layers.has_entry(layer):
        shown = document.layers.get(layer)
        if shown.is_off() or shown.is_frozen():
            value = f"on the hidden layer {layer}"
            raise InputError(file, label, value, "a visible layer or no entity")
    if entity.dxf.get("invisible", 0):
        raise InputError(file, label, "invisible", "a visible entity or none")


def _open(file: Path) -> tuple[Any, bool]:
    """The document, and whether its file says a unit: ezdxf makes up one for a missing header."""
    try:
        text = file.read_bytes()
    except OSError as error:
        raise InputError(file, "drawing", "unreadable", f"a DXF file ({error.strerror})") from error
    if not text.strip():
        raise InputError(file, "drawing", "empty", "a DXF file")
    try:
        return ezdxf.readfile(file), b"$INSUNITS" in text
    except Exception as error:  # a broken file can break the parser anywhere
        reason = " ".join(str(error).split()).rstrip(".") or type(error).__name__
        raise InputError(file, "drawing", f"broken ({reason})", "a valid DXF file") from error


def _metres_per_unit(document: Any, file: Path) -> float:
    code = document.header.get("$INSUNITS", 0)
    if code not in _METRES_PER_UNIT:
        raise InputError(file, "$INSUNITS", code, "a known unit such as 4 (mm) or 1 (inch)")
    return _METRES_PER_UNIT[code]


def _layer_feeds(document: Any, file: Path, settings: PathSettings) -> dict[str, float]:
    known = {layer.dxf.name.lower() for layer in document.layers}
    known |= {entity.dxf.layer.lower() for entity in document.modelspace()}
    for name in settings.layer_feeds_m_per_s:
        if name.lower() not in known:
            raise InputError(
                None, f"path.layer_feeds_m_per_s.{name}", None, f"a layer of {file.name}"
            )
    return {name.lower(): feed for name, feed in settings.layer_feeds_m_per_s.items()}


@dataclass
class _Exploder:
    """Takes blocks apart, and counts how often, since a few blocks can stand for billions."""

    file: Path
    copies: int = 0

    def flat(
        self, entities: Any, handle: str = "", layer: str = "0", blocks: tuple[str, ...] = ()
    ) -> Iterator[tuple[Any, str, str]]:
        """Entities with handle and layer; a block's layer "0" is the layer of its INSERT."""
        for entity in entities:
            own_handle = handle or entity.dxf.handle
            label = f"{entity.dxftype()} #{own_handle}"
            check_supported(entity, label, self.file)
            own_layer = layer if handle and entity.dxf.layer == "0" else entity.dxf.layer
            if entity.dxftype() != "INSERT":
                yield entity, own_handle, own_layer
                continue
            self._check_block(entity, label, blocks)
            inner = (*blocks, entity.dxf.name)
            refuse = _refuse_skipped(label, self.file)
            for copy in entity.multi_insert() if entity.mcount > 1 else [entity]:
                parts = copy.virtual_entities(skipped_entity_callback=refuse)
                yield from self.flat(parts, own_handle, own_layer, inner)

    def _check_block(self, insert: Any, label: str, blocks: tuple[str, ...]) -> None:
        name = insert.dxf.get("name", "?")
        if insert.block() is None:
            raise InputError(self.file, label, f"of the missing block {name}", "a defined block")
        if name in blocks:
            value = f"of block {name} within itself"
            raise InputError(self.file, label, value, "blocks without loops")
        self.copies += insert.mcount
        if self.copies > _MOST_COPIES or len(blocks) > _DEEPEST:
            expected = f"at most {_MOST_COPIES} copies of blocks, {_DEEPEST} deep"
            value = f"{self.copies} copies of blocks, {len(blocks)} deep"
            raise InputError(self.file, label, value, expected)


def _refuse_skipped(label: str, file: Path) -> Callable[[Any, str], None]:
    """What ezdxf calls when it cannot transform a part of a block."""

    def refuse(part: Any, reason: str) -> None:
        value = f"of a block whose {part.dxftype()} cannot be placed ({reason.rstrip('.')})"
        raise InputError(file, label, value, "a block of lines and curves")

    return refuse
