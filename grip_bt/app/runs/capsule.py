"""A run as one HTML file that needs no server and nothing from the network: to send, to keep, to look at in ten years.

The page has the task's text, both drawings, parameters, variables and all events, with a time line to go through them.
It is put together from `capsule_page/`; events are deflated JSON, which a browser inflates by itself.
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from typing import Any

from grip_bt import __version__
from grip_bt.app.project.catalogue import project_catalog
from grip_bt.base.errors import DocumentError
from grip_bt.formats.draw import View, to_svg
from grip_bt.formats.draw.views import describe
from grip_bt.runtime import Event, JournalReader, RunRecord
from grip_bt.task import Leaf, Task, loads, outcomes_of, walk
from grip_bt.task.catalog import Catalog

MOST_TEXT = 900_000
"""Most bytes, deflated, of what events say beyond their kind; where there is more, some of it is left out."""
_LONGEST = 200
_SHORT = 40
_MICRO = 1e6


@dataclass(frozen=True)
class Capsule:
    """What was written: how many events, how many bytes, and in words what was left out, if anything."""

    events: int
    size: int
    left_out: str


def write_capsule(reader: JournalReader, run: str, file: Path) -> Capsule:
    """Write a run as one HTML file.

    Raises:
        UnknownNameError: there is no such run.
        DocumentError: the file can't be written, or the task that was run can't be read any more.
    """
    record = reader.run(run)
    events = list(reader.iterate(run))
    task = loads(record.task_text, record.task_path or run)
    columns, left_out = columns_of(events)
    # GRIP's own nodes where the task's project isn't there any more
    catalog = project_catalog(record.task_path) if Path(record.task_path).is_file() else Catalog.builtin()
    page = _page(record, task, catalog, columns, left_out)
    try:
        file.write_text(page, encoding="utf-8", errors="backslashreplace")
    except OSError as error:
        raise DocumentError(f"can't be written: {error.strerror}", str(file)) from None
    return Capsule(len(events), file.stat().st_size, left_out)


def _page(record: RunRecord, task: Task, catalog: Catalog, columns: Mapping[str, object], left_out: str) -> str:
    facts = {
        "run": {k: v for k, v in vars(record).items() if k not in ("task_text", "task_path")},
        "file": Path(record.task_path).name,
        "doc": task.doc,
        "nodes": {path: _node(node, catalog) for path, node in walk(task.root)},
        "events": columns,
        "left_out": left_out,
        "grip": __version__,
    }
    parts = {
        "TITLE": escape(f"{task.name}, run {record.id}"),
        "STYLE": _asset("style.css"),
        "SCRIPT": _asset("page.js"),
        "TREE": _drawing(task, catalog, "tree"),
        "FLOW": _drawing(task, catalog, "flow"),
        "TEXT": escape(record.task_text),
        # `</script>` in a text would end the element; in JSON the slash may be escaped.
        "FACTS": json.dumps(facts, default=str, ensure_ascii=False).replace("<", "\\u003c"),
    }
    page = _asset("page.html")
    # in one pass, so that a text which looks like a mark is left alone
    pieces = page.split("@@")
    return "".join(parts[piece] if i % 2 else piece for i, piece in enumerate(pieces))


def _asset(name: str) -> str:
    return (files("grip_bt.app.runs") / "capsule_page" / name).read_text(encoding="utf-8")


def _drawing(task: Task, catalog: Catalog, view: View) -> str:
    drawn = to_svg(task, catalog, view, paths=True)
    return drawn.replace('id="arrow"', f'id="arrow-{view}"').replace("url(#arrow)", f"url(#arrow-{view})")


def _node(node: Any, catalog: Catalog) -> dict[str, Any]:
    manifest = catalog.get(node.node) if isinstance(node, Leaf) and node.node in catalog else None
    outcomes = dict(outcomes_of(node)) if not isinstance(node, Leaf) else {"success": "success", "failure": "failure"}
    if isinstance(node, Leaf):
        outcomes = outcomes | node.meaning if manifest is None else manifest.outcomes_for(dict(node.meaning))
    return {
        "what": describe(node),
        "doc": node.doc or (manifest.doc if manifest is not None else ""),
        "outcomes": outcomes,
        "with": dict(getattr(node, "with_", {})),
        "in": dict(getattr(node, "in_", {})),
        "out": dict(getattr(node, "out", {})),
    }


# --- events ---


def columns_of(events: list[Event]) -> tuple[dict[str, Any], str]:
    """Return events for the page, and in words what was left out.

    Kinds of events stand in a table once; a column has their numbers, another the microseconds since the event before.
    """
    kinds: dict[tuple[str | None, ...], int] = {}
    numbers = [kinds.setdefault((e.path, e.event, e.outcome, e.code, e.meaning), len(kinds)) for e in events]
    at = [0, *(round(e.t * _MICRO) for e in events)]
    texts, left_out = _texts(events)
    steps = [now - before for before, now in pairwise(at)]
    return {"kinds": list(kinds), "columns": _packed([numbers, steps]), "texts": texts}, left_out


def _packed(content: object) -> str:
    text = json.dumps(content, ensure_ascii=False, separators=(",", ":"), default=str)
    return base64.b64encode(zlib.compress(text.encode(), 9, -zlib.MAX_WBITS)).decode()


def _texts(events: list[Event]) -> tuple[str, str]:
    """Return what events say, packed, in as many words as there is room for; and what was left out."""
    packed = left_out = ""
    for keep, longest, without in (
        (True, _LONGEST, ""),
        (False, _SHORT, "messages of running nodes, and the ends of long texts"),
        (False, 0, "messages and values of events, of which there are too many"),
    ):
        said = {str(i): _said(e, longest) for i, e in enumerate(events) if e.data and (keep or e.event != "message")}
        packed = _packed({i: data for i, data in said.items() if data})
        left_out = without
        if len(packed) <= MOST_TEXT:
            break
    return packed, left_out


def _said(event: Event, longest: int) -> dict[str, Any]:
    """Return the data of an event in short; a value is there by its preview."""
    data = {k: v for k, v in event.data.items() if k not in ("value", "hash", "size", "data")}
    if longest == 0:
        data = {k: v for k, v in data.items() if k in ("variable", "state", "status")}
    most = {k: max(10 * longest if k == "traceback" else longest, _SHORT) for k in data}
    return {k: v[: most[k] - 1] + "…" if isinstance(v, str) and len(v) > most[k] else v for k, v in data.items()}
