"""Hypothesis strategies for commands on a given task: mostly ones that make sense, some that don't."""

from hypothesis import strategies as st
from random_tasks import leaves, literals, names, nodes, texts

from grip_bt.task import KINDS, Leaf, children_of, dumps, loads, walk
from grip_bt.task.edit import clip_of, command_of

FIELDS = {
    "retry": {"times": 2},
    "timeout": {"seconds": 1.5},
    "force": {"as": "failure"},
    "guard": {"if": "a < 3"},
    "switch": {"on_value": "a", "cases": {}},
    "for_each": {"items": "all", "item": "one"},
    "cooldown": {"seconds": 2},
}
GROUPS = ["add", "remove", "move", "rename", "set", "unset", "connect", "disconnect", "wrap", "unwrap", "change_kind",
          "set_meaning", "declare", "undeclare", "rename_variable", "rename_outcome",
          "paste", "comment"]  # fmt: skip


def _data(node):
    """Return a node as it stands in a file."""
    from grip_bt.task.canonical import file_data

    return file_data(node)


@st.composite
def commands(draw, task, kinds=tuple(GROUPS)):
    """Return a command on a task."""
    every = list(walk(task.root))
    path, node = draw(st.sampled_from(every))
    containers = [p for p, n in every if not isinstance(n, Leaf)] or ["/"]
    do = draw(st.sampled_from(kinds))
    make = _MAKERS[do]
    return command_of({"do": do, **make(draw, task, path, node, containers)})


def _add(draw, task, path, node, containers):
    index = draw(st.none() | st.integers(0, 4))
    new = _data(draw(leaves | nodes))
    return {"parent": draw(st.sampled_from(containers)), "name": draw(names), "node": new, "index": index}


def _move(draw, task, path, node, containers):
    index = draw(st.none() | st.integers(0, 4))
    parent = draw(st.sampled_from(containers) | st.just(path.rpartition("/")[0] or "/"))
    return {"path": path, "parent": parent, "index": index, "name": draw(st.none() | names)}


def _set(draw, task, path, node, containers):
    where = draw(st.sampled_from(["", path]))
    key, value = draw(
        st.tuples(st.just(("doc",)), texts)
        | st.tuples(st.sampled_from([("x-a",), ("x-b", "inner")]), literals)
        | st.tuples(texts.map(lambda name: ("with", name)), literals)
        | st.tuples(st.tuples(st.sampled_from(["in", "out"]), texts), texts)
        | st.sampled_from([(("times",), 3), (("seconds",), 2.5), (("memory",), False), (("policy",), "any")])
        | st.tuples(st.just(("name",)), texts)
    )
    return {"path": where, "key": key, "value": value}


def _unset(draw, task, path, node, containers):
    where, holder = draw(st.sampled_from([("", task), (path, node)]))
    keys = [k for k in _data(holder) if k not in ("kind", "node", "root", "children", "child")] or ["doc"]
    key = draw(st.sampled_from(keys))
    inner = _data(holder).get(key)
    if isinstance(inner, dict) and inner and draw(st.booleans()):
        return {"path": where, "key": (key, draw(st.sampled_from(list(inner))))}
    return {"path": where, "key": (key,)}


def _connect(draw, task, path, node, containers):
    above = path.rpartition("/")[0] or "/"
    parent = task.root if above == "/" else dict(walk(task.root))[above]
    around = [*task.outcomes] if path == "/" else [*children_of(parent), *parent.outcomes, "success"]
    outcome = draw(st.sampled_from(["success", "failure", "failure.no_ik", "none"]))
    return {"path": path, "outcome": outcome, "target": draw(st.sampled_from(around))}


def _disconnect(draw, task, path, node, containers):
    return {"path": path, "outcome": draw(st.sampled_from([*node.on, "success"]))}


def _wrap(draw, task, path, node, containers):
    paths = [path]
    above, _, name = path.rpartition("/")
    if path != "/" and draw(st.booleans()):
        siblings = list(children_of(dict(walk(task.root))[above or "/"]))
        begin = siblings.index(name)
        paths = [f"{above}/{n}" if above else n for n in siblings[begin : begin + draw(st.integers(1, 3))]]
    kind = draw(st.sampled_from(list(KINDS)))
    return {"paths": paths, "kind": kind, "name": draw(names), "fields": FIELDS.get(kind, {})}


def _change_kind(draw, task, path, node, containers):
    kind = draw(st.sampled_from(list(KINDS)))
    return {"path": draw(st.sampled_from(containers)), "kind": kind, "fields": FIELDS.get(kind, {})}


def _set_meaning(draw, task, path, node, containers):
    return {
        "path": draw(st.sampled_from(["", path])),
        "outcome": draw(names),
        "meaning": draw(st.sampled_from(["success", "failure", None])),
    }


def _holder(draw, task, containers):
    path = draw(st.sampled_from(["", *containers]))
    data = task.data if path == "" else getattr(dict(walk(task.root))[path], "data", {})
    return path, list(data) or ["a"]


def _declare(draw, task, path, node, containers):
    variable = draw(st.sampled_from(["int", {"type": "int", "value": 3}, {"type": "Pose", "doc": "where"}]))
    index = draw(st.none() | st.integers(0, 3))
    return {"path": _holder(draw, task, containers)[0], "name": draw(names), "variable": variable, "index": index}


def _undeclare(draw, task, path, node, containers):
    where, there = _holder(draw, task, containers)
    return {"path": where, "name": draw(st.sampled_from(there))}


def _paste(draw, task, path, node, containers):
    return {
        "parent": draw(st.sampled_from(containers)),
        "clip": clip_of(task, path).model_dump(),
        "index": draw(st.none() | st.integers(0, 4)),
        "variables": draw(st.sampled_from(["share", "fresh"])),
    }


def _rename_outcome(draw, task, path, node, containers):
    where = draw(st.sampled_from(["", *containers]))
    holder = task if where == "" else dict(walk(task.root))[where]
    there = list(getattr(holder, "outcomes", ())) or ["success"]
    return {"path": where, "outcome": draw(st.sampled_from(there)), "to": draw(names)}


_MAKERS = {
    "add": _add,
    "remove": lambda draw, task, path, node, containers: {"path": path},
    "move": _move,
    "rename": lambda draw, task, path, node, containers: {"path": path, "name": draw(names)},
    "set": _set,
    "unset": _unset,
    "connect": _connect,
    "disconnect": _disconnect,
    "wrap": _wrap,
    "unwrap": lambda draw, task, path, node, containers: {"path": path},
    "change_kind": _change_kind,
    "set_meaning": _set_meaning,
    "declare": _declare,
    "undeclare": _undeclare,
    "rename_outcome": _rename_outcome,
    "comment": lambda draw, task, path, node, containers: {
        "path": draw(st.sampled_from([path, path, ""])),
        "text": draw(texts),
    },
    "paste": _paste,
    "rename_variable": lambda draw, task, path, node, containers: {
        **_undeclare(draw, task, path, node, containers),
        "to": draw(names),
    },
}


def reachable(task):
    """Return a task as a file gives it."""
    return loads(dumps(task))
