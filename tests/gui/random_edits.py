"""Random edits of two pages on one task file: mostly ones that make sense, some late, some wrong."""

from __future__ import annotations

from random import Random
from typing import Any

from grip_bt.task import Leaf, StateMachine, Task, children_of, outcomes_of, walk

NAMES = ["look", "take", "put", "again", "wait a bit", "a", "b", "c", "on", "x1"]
LEAVES = [
    {"node": "flow/wait", "with": {"seconds": 0.5}},
    {"node": "flow/fail", "with": {"code": "no_plan", "message": "with: colon, 'quotes' # and more"}},
    {"node": "nobody/knows", "in": {"cloud": "cloud"}, "out": {"grasp": "grasp"}},
]
KINDS: dict[str, dict[str, Any]] = {
    "sequence": {},
    "fallback": {"memory": False},
    "parallel": {},
    "retry": {"times": 2},
    "timeout": {"seconds": 1.5},
    "invert": {},
    "state_machine": {"initial": "a", "outcomes": {"success": "success", "failure": "failure"}},
}


def random_command(random: Random, task: Task) -> dict[str, Any]:
    """Return a command as a page sends it."""
    every = list(walk(task.root))
    path, node = random.choice(every)
    parent = random.choice([p for p, n in every if not isinstance(n, Leaf)] or ["/"])
    if len(every) > 40 and random.random() < 0.5:
        return {"do": "remove", "path": path}
    do = random.choice(list(_MAKERS))
    return {"do": do, **_MAKERS[do](random, task, path, node, parent)}


def _siblings(random: Random, task: Task, path: str) -> list[str]:
    above = path.rpartition("/")[0] or "/"
    names = list(children_of(dict(walk(task.root))[above])) if path != "/" else []
    if not names:
        return [path]
    start = random.randrange(len(names))
    return [n if above == "/" else f"{above}/{n}" for n in names[start : start + random.randint(1, 2)]]


def _connect(random: Random, task: Task, path: str, node: Any, parent: str) -> dict[str, Any]:
    above = dict(walk(task.root))[path.rpartition("/")[0] or "/"]
    ends = list(task.outcomes) if path == "/" or isinstance(above, Leaf) else list(outcomes_of(above))
    siblings = list(children_of(above)) if isinstance(above, StateMachine) else []
    outcome = random.choice(["success", "failure", "failure.no_plan", "none"])
    return {"path": path, "outcome": outcome, "target": random.choice([*ends, *siblings, "nowhere"])}


def _wrap(random: Random, task: Task, path: str, node: Any, parent: str) -> dict[str, Any]:
    kind = random.choice(list(KINDS))
    return {"paths": _siblings(random, task, path), "kind": kind, "name": random.choice(NAMES), "fields": KINDS[kind]}


def _change_kind(random: Random, task: Task, path: str, node: Any, parent: str) -> dict[str, Any]:
    kind = random.choice(list(KINDS))
    return {"path": parent, "kind": kind, "fields": KINDS[kind]}


_MAKERS: dict[str, Any] = {
    "add": lambda r, t, p, n, c: {
        "parent": c, "name": r.choice(NAMES), "node": r.choice(LEAVES), "index": r.choice([None, 0, 1, 7])
    },
    "remove": lambda r, t, p, n, c: {"path": p},
    "move": lambda r, t, p, n, c: {"path": p, "parent": c, "index": r.choice([None, 0, 1, 2]), "name": None},
    "rename": lambda r, t, p, n, c: {"path": p, "name": r.choice(NAMES)},
    "set": lambda r, t, p, n, c: {
        "path": p,
        "key": r.choice([["doc"], ["x-note"], ["with", "seconds"], ["times"], ["in", "cloud"]]),
        "value": r.choice(["a text\nof two lines", 3, 0.25, None, "#", ["a", {"b": 1}], "- x"]),
    },
    "unset": lambda r, t, p, n, c: {
        "path": p,
        "key": r.choice([["doc"], ["x-note"], ["with"], ["in", "cloud"], ["exits"]]),
    },
    "connect": _connect,
    "disconnect": lambda r, t, p, n, c: {"path": p, "outcome": r.choice(["success", "failure"])},
    "wrap": _wrap,
    "unwrap": lambda r, t, p, n, c: {"path": c},
    "change_kind": _change_kind,
    "declare": lambda r, t, p, n, c: {"path": r.choice(["", c]), "name": r.choice(NAMES), "variable": "int"},
    "undeclare": lambda r, t, p, n, c: {"path": r.choice(["", c]), "name": r.choice(NAMES)},
    "set_meaning": lambda r, t, p, n, c: {"path": p, "outcome": "none", "meaning": r.choice(["success", "failure"])},
}  # fmt: skip


def random_typing(random: Random, text: str) -> str:
    """Return a text as a person may leave it: a comment more, a line less, a piece twice, a word changed."""
    lines = text.splitlines(keepends=True)
    at = random.randrange(len(lines)) if lines else 0
    what = random.randrange(4)
    if what == 0:
        lines.insert(at, "# a remark\n")
    elif what == 1 and lines:
        del lines[at]
    elif what == 2 and lines:
        lines.insert(at, lines[at])
    elif lines:
        lines[at] = lines[at].replace("wait", random.choice(["wait", "wiat", "{", "look"]))
    return "".join(lines)
