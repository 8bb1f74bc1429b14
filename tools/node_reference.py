"""The reference page of the built-in nodes, made from their manifests.

`python tools/node_reference.py docs/nodes.md` writes it; a test fails when the page is older than
the manifests.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.catalog.ros_config import sensor_manifest

_HEAD = """# Nodes

Every leaf that comes with GRIP: its parameters (`with:`), inputs (`in:`), outputs (`out:`), outcomes, and the codes
with which it may fail (`on: {failure.<code>: ...}`). Made from `grip_bt/task/catalog/builtin/*.yaml` by
`python tools/node_reference.py docs/nodes.md`; don't edit it by hand.

A project adds `sensor/<name>` for each of its sensors, `component/<name>` for each of its components, and its own
nodes. Leaves that move something fail with `canceled` when somebody else stopped the motion, and with `preempted` when
the task was asked to end while it was under way.
"""


def reference(manifests: Iterable[Manifest]) -> str:
    """Return the page, one section per group of ids, in Markdown."""
    groups: dict[str, list[Manifest]] = {}
    for manifest in manifests:
        groups.setdefault(manifest.id.split("/")[0], []).append(manifest)
    parts = [_HEAD]
    for group in sorted(groups):
        parts.append(f"\n## {group}\n")
        parts.extend(_node(manifest) for manifest in sorted(groups[group], key=lambda m: m.id))
    return "".join(parts)


def builtin_reference() -> str:
    """Return the page of the nodes that come with GRIP, with one sensor as an example."""
    return reference([*Catalog.builtin(), sensor_manifest("NAME")])


def _node(manifest: Manifest) -> str:
    lines = [f"\n### {manifest.id}\n", manifest.doc, ""]
    rows = [
        *(
            ("parameter", name, p.type, _default(p.required, p.default), p.doc)
            for name, p in manifest.parameters.items()
        ),
        *(("input", name, i.type, "" if i.required else "optional", i.doc) for name, i in manifest.inputs.items()),
        *(
            ("output", name, o.type, f"on {', '.join(o.on)}" if o.on else "", o.doc)
            for name, o in manifest.outputs.items()
        ),
    ]
    if rows:
        lines += ["| | name | type | | |", "|---|---|---|---|---|"]
        lines += [
            f"| {what} | `{name}` | `{_cell(type_)}` | {note} | {_cell(doc)} |" for what, name, type_, note, doc in rows
        ]
        lines.append("")
    outcomes = ", ".join(
        f"`{label}`" + ("" if label == means else f" ({means})") for label, means in manifest.outcomes.items()
    )
    lines.append(f"Outcomes: {outcomes}.")
    if manifest.codes:
        lines[-1] += f" Codes: {', '.join(f'`{code}`' for code in manifest.codes)}."
    return "\n".join(lines) + "\n"


def _default(required: bool, value: object) -> str:
    return "required" if required else f"default `{value!r}`"


def _cell(text: str) -> str:
    return text.replace("|", r"\|")


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(builtin_reference(), encoding="utf-8")
