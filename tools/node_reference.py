"""The reference pages of the built-in nodes, made from their manifests: those that one writes, and those of imports.

`python tools/node_reference.py docs` writes them; a test fails when a page is older than the manifests.
"""

from __future__ import annotations

import re
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.catalog.ros_config import sensor_manifest

_HEAD = """# Nodes

Every leaf that comes with GRIP for you to use, with its ports; [others](imported_nodes.md) are written by imports. A
project adds `sensor/NAME` for each sensor, `component/NAME` for each component, and [its own](own_nodes.md). `with` are
parameters, written in the task; `in` and `out` are bound to variables. What has no default and isn't optional is
required.

A node ends with `success`, or with `failure` where codes are listed (`on: {failure.CODE: ...}`). Nodes that move or
plan also fail with `canceled` when stopped from elsewhere, and `preempted` when the task was asked to end.
"""
_IMPORTED_HEAD = """# Nodes of imported tasks

What `grip import` writes where a node of BehaviorTree.CPP, Nav2 or SMACH has no equal kind, so that a task does
exactly the same. A node that speaks of children is the first child of a
[`kind: control`](own_nodes.md#a-control-node), and they are the others. Tables are read as in [Nodes](nodes.md).
"""
_IMPORTED = ("btcpp", "nav2", "smach")
EXAMPLES = {
    "arm": "{node: arm/move_to, with: {arm: right, state: home}}",
    "btcpp": "{node: btcpp/WasEntryUpdated, in: {entry: goal}}",
    "flow": "{node: flow/compute, with: {expression: a + 1}, in: {a: tries}, out: {value: tries}}",
    "grasp": "{node: grasp/choose, in: {grasps: grasps, tried: tried}, out: {grasp: grasp}}",
    "hand": "{node: hand/close, with: {force: 5}, in: {grasp: grasp}}",
    "messages": "{node: messages/get, with: {store: poses, name: above_bin}, out: {value: pose}}",
    "nav2": "{node: nav2/RateController, with: {hz: 2}}",
    "perception": "{node: perception/image_difference, in: {before: before, after: after, grasp: grasp}}",
    "pose": "{node: pose/offset, with: {position: [0, 0, 0.1]}, in: {pose: pose}, out: {moved: above}}",
    "ros": "{node: ros/publish, with: {topic: /light, type: std_msgs/msg/Bool}, in: {value: lit}}",
    "scene": "{node: scene/update_from_cloud, in: {cloud: cloud}, out: {count: seen}}",
    "sensor": "{node: sensor/NAME, out: {points: cloud}}",
    "smach": "{node: smach/next_item, with: {items: [1, 2]}, in: {position: k}, out: {position: k, item: item}}",
}
"""One node of each group, as a task has it."""
_SHARED = 2
"""From so many nodes of a group on, a port is explained once."""
_SIDES = ("with", "in", "out")
_EVERYWHERE = ("canceled", "preempted")
_BOUND = "in place of the parameter"


@dataclass(frozen=True)
class _Port:
    """One line of a node's table."""

    side: str
    name: str
    type: str
    doc: str


def builtin_reference() -> dict[str, str]:
    """Return the pages of the nodes that come with GRIP, with one sensor as an example: file's name -> Markdown."""
    groups: dict[str, list[Manifest]] = {}
    for manifest in [*Catalog.builtin(), sensor_manifest("NAME")]:
        groups.setdefault(manifest.id.split("/")[0], []).append(manifest)
    sections = {name: _group(name, sorted(groups[name], key=lambda m: m.id)) for name in sorted(groups)}
    imported = "".join(sections.pop(name) for name in _IMPORTED)
    return {"nodes.md": _HEAD + "".join(sections.values()), "imported_nodes.md": _IMPORTED_HEAD + imported}


def _group(name: str, manifests: Sequence[Manifest]) -> str:
    counted = Counter(port for manifest in manifests for port in set(_ports(manifest)))
    shared = [port for port, many in counted.items() if many >= _SHARED]
    shared.sort(key=lambda port: (_SIDES.index(port.side), len(port.name) > 1, port.name))
    usual, many = Counter(_ends(manifest) for manifest in manifests).most_common(1)[0]
    usual = usual if many > len(manifests) / 2 else ()
    parts = [f"\n## {name}\n\n```yaml\n{EXAMPLES[name]}\n```\n"]
    if usual:
        parts.append(f"\nUnless more is said, {name} nodes also end with {', '.join(usual)}.\n")
    if shared:
        parts.append(f"\nShared ports:\n{_table(shared)}")
    for _, alike in groupby(manifests, key=lambda m: (m.doc, tuple(_ports(m)), tuple(m.outcomes.items()))):
        parts.append(_node(list(alike), shared, usual))
    return "".join(parts)


def _node(alike: Sequence[Manifest], shared: Sequence[_Port], usual: tuple[str, ...]) -> str:
    """Return the section of nodes that differ by their names only."""
    manifest, ports = alike[0], list(_ports(alike[0]))
    own = [port for port in ports if port not in shared]
    known = {side: _listed([p.name for p in ports if p in shared and p.side == side]) for side in _SIDES}
    ends = _ends(manifest)
    codes = [f"`{code}`" for code in manifest.codes if code not in _EVERYWHERE]
    lines = [
        *(f"{side.capitalize()} {names}." for side, names in known.items() if names),
        *([f"Also ends with {', '.join(ends)}."] if ends and ends != usual else []),
        *(["Has no other outcome."] if usual and not ends else []),
        *(["Always fails."] if "success" not in manifest.outcomes else []),
        *([f"Codes: {', '.join(codes)}."] if codes else []),
    ]
    title = ", ".join([manifest.id, *(each.id.split("/")[1] for each in alike[1:])])
    tail = f"\n{' '.join(lines)}\n" if lines else ""
    return f"\n### {title}\n\n{manifest.doc}\n{_table(own) if own else ''}{tail}"


def _listed(names: Sequence[str]) -> str:
    """Return names as code, those of the inputs `a` to `h` as a range."""
    if names[:3] == ["a", "b", "c"]:
        return f"`a` … `{names[-1]}`"
    return ", ".join(f"`{name}`" for name in names)


def _ends(manifest: Manifest) -> tuple[str, ...]:
    """Return the outcomes of a node besides success and failure, each with what it means."""
    return tuple(
        f"`{label}`" + ("" if label == means else f" ({means})")
        for label, means in manifest.outcomes.items()
        if label not in ("success", "failure")
    )


def _ports(manifest: Manifest) -> Iterator[_Port]:
    """Yield what a node's table says; an input that stands for a parameter is said with that."""
    for name, p in manifest.parameters.items():
        bound = name in manifest.inputs and manifest.inputs[name].doc == _BOUND
        type_ = f"`{p.type}`" if p.required else f"`{p.type} = {p.default!r}`"
        yield _Port("with", name, type_ + (" or bound" if bound else ""), p.doc)
    for name, i in manifest.inputs.items():
        if i.doc != _BOUND:
            yield _Port("in", name, f"`{i.type}`" + ("" if i.required else " optional"), i.doc)
    for name, o in manifest.outputs.items():
        also = [label for label in o.on if label not in ("success", "failure", "skipped")]
        yield _Port("out", name, f"`{o.type}`" + (f" also on {', '.join(also)}" if also else ""), o.doc)


def _table(ports: Sequence[_Port]) -> str:
    """Return the ports as a table; numbered or lettered ones that are alike share a line."""
    rows, side = ["", "| | | | |", "|---|---|---|---|"], ""
    for _, alike in groupby(ports, key=lambda p: (p.side, re.sub(r"^[a-h]$|_\d$", "", p.name), p.type)):
        first, *rest = alike
        name = f"`{first.name}`" + (f" … `{rest[-1].name}`" if rest else "")
        rows.append(
            f"| {first.side if first.side != side else ''} | {name} | {_cell(first.type)} | {_cell(first.doc)} |"
        )
        side = first.side
    return "\n".join(rows) + "\n"


def _cell(text: str) -> str:
    return text.replace("|", r"\|")


if __name__ == "__main__":
    for page, text in builtin_reference().items():
        (Path(sys.argv[1]) / page).write_text(text, encoding="utf-8")
