"""``manifest.json``: what a build contains, for people and for tools."""

from __future__ import annotations

import hashlib
import json

from servogen import __version__
from servogen.controllers.design import Declaration, Port

SCHEMA = "servogen.manifest/1"


def _port(port: Port) -> dict[str, object]:
    return {
        "name": port.name,
        "unit": port.unit,
        "size": port.size,
        "type": "int32" if port.integer else "real",
        "range": None if port.low is None else [port.low, port.high],
        "doc": port.doc,
    }


def _controller(d: Declaration) -> dict[str, object]:
    maps = {m.name: {"doc": m.doc, "values": m.values.tolist()} for m in d.maps}
    return {
        "prefix": d.prefix,
        "kind": d.kind,
        "summary": d.summary,
        "sample_time_s": d.sample_time_s,
        "dimensions": {dim.name: dim.value for dim in d.dimensions},
        "table_bytes": d.table_bytes,
        "tables": {t.name: list(t.values.shape) for t in d.tables},
        "uses": list(d.uses),
        **({"maps": maps} if maps else {}),
        "entry_points": [
            {
                "name": f"{d.prefix}_{op.name}",
                "doc": op.doc,
                "returns_status": op.returns_status,
                "inputs": [_port(port) for port in op.inputs],
                "outputs": [_port(port) for port in op.outputs],
            }
            for op in d.operations
        ],
    }


def manifest_text(
    name: str, digest: str, declarations: tuple[Declaration, ...], files: dict[str, str]
) -> str:
    """JSON text, keys in a fixed order, with the sha-256 of every other file."""
    content = {
        "schema": SCHEMA,
        "servogen": __version__,
        "package": name,
        "design_hash": digest,
        "precision": declarations[0].precision.name,
        "flags": ["-std=c99", "-ffp-contract=off"],
        "table_bytes": sum(d.table_bytes for d in declarations),
        "controllers": [_controller(d) for d in declarations],
        "files": {file: hashlib.sha256(text.encode()).hexdigest() for file, text in files.items()},
    }
    return json.dumps(content, indent=1) + "\n"
