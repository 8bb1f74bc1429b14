"""Documents made from the schema: every kind, every key with values, every built-in leaf, in each other.

They can be read; right they mostly aren't. Whoever adds a key to the language gives it values here.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

from hypothesis import strategies as st
from pydantic import BaseModel

from grip_bt.task import model
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.document import keys_of
from grip_bt.task.model import KINDS

CATALOG = Catalog.builtin()
WORDS = ["success", "failure", "a", "b", "done", "zz", "failure.zz", "", "."]
EXPRESSIONS = ["true", "x < 2", "nope > 1", "x +", "1 / 0 > 1", "x", "len(l) > 0 and not t", "", "'a' in l"]
ENDS = [
    *({}, {"success": "a"}, {"success": "success", "failure": "failure"}, {"failure.zz": "failure"}, {"zz": "zz"}),
    *({"": ""}, {".": "."}, {"success.": "b"}, {"a.b.c.d": "done"}, {"success": "b", "failure": "done"}),
]
EXITS = [
    *({}, {"a.success": "done"}, {"a.failure.zz": "failure"}, {"a.failure": "zz"}, {"zz.success": "success"}),
    *({"a": "a"}, {"": ""}, {"a..": "success"}, {"..": ".."}, {"a.success.zz": "failure", "b.failure": "success"}),
]
VARIABLES = [
    *({"x": "int"}, {"x": {"type": "int", "value": 1}}, {"x": "Nope"}, {"l": {"type": "list[int]", "value": [1, 2]}}),
    *(
        {"t": {"type": "bool", "value": True}, "x": {"type": "float", "value": "a"}},
        {"g": "list[Grasp]"},
        {"x": "list["},
    ),
    *({"f": {"type": "Any", "value": {"a": [1, None, 2.5]}}}, {"x": "int | None"}, {"i": "dict[str, Pose]"}),
]
VALUES: dict[str, list[Any]] = {
    "doc": ["Words: of # all | kinds.\nTwo lines."],
    "precondition": EXPRESSIONS,
    **dict.fromkeys(("if", "while", "on_value"), EXPRESSIONS),
    "on": ENDS,
    "exits": EXITS,
    "outcomes": [{"done": "success"}, {"success": "failure"}, {"failure": "success"}, {"zz": "failure"}],
    "data": VARIABLES,
    **dict.fromkeys(("memory", "retick", "prompt", "child_first"), [True, False]),
    "policy": ["all", "any", "success"],
    "cancel": ["halt", "ask", "join"],
    "order": ["declared", None],
    "rules": [
        *([], [{"then": "success"}], [{"when": {"a": "failure.zz"}, "then": "done"}], [{"then": "zz"}, {"then": ""}]),
        *([{"at_least": 9, "ends": "failure", "then": "failure"}], [{"when": {"zz": []}, "then": "failure"}]),
        [{"when": {"a": ["success", "zz.zz"], "b": "."}, "at_least": 1, "then": "success"}],
    ],
    "wait_for": ["all", "any", 1, 7, [], ["a"], ["zz", "a"], None],
    "initial": WORDS,
    "default": WORDS,
    "times": [1, 3, 10**9, None],
    "seconds": [0.001, 1e308, float("inf"), float("nan"), 3],
    "cases": [{}, {"a": 1, "b": [2, "x", None]}, {"zz": True}, {"a": [1, 1], "b": 1.0}, {"a": float("nan")}],
    "items": ["l", "x", "zz", ""],
    "item": ["i", "x", "l", "a b"],
    "as": ["success", "failure"],
    "behaviour": ["py_trees.behaviours:Success", "py_trees.behaviours:Count", "os:system", "py_trees.nope:X"],
    "args": [{}, {"name": "n"}, {"zz": [1, {"a": None}]}, {"fail_until": 1, "running_until": 2, "success_until": 3}],
    "built_by": ["", "os:system", "py_trees.demos.selector:create_root"],
    "at": ["/", "zz"],
    "task": ["tasks/fetch.yaml", "nope.yaml", "../up.yaml", "/etc/passwd", "\0", "a" * 300],
    "with": [{}, {"zz": 1}, {"seconds": 0, "message": "m", "code": "zz", "value": [1]}, {"name": "n", "type": "Nope["}],
    "in": [{}, {"value": "x"}, {"zz": "x"}, {"value": "zz", "": ""}, {"grasp": "g", "target": "x"}],
    "out": [{}, {"value": "x"}, {"zz": "zz"}, {"value": "l", "count": "x"}],
    "meaning": [{"success": "failure"}, {"failure": "success"}, {"zz": "failure"}],
    "x-note": [{"a": [1]}, None, "y"],
    "node": [],
    "kind": [],
    "children": [],
    "child": [],
}  # fmt: skip
"""Key of a node -> what one may write there; nodes and children are made of each other."""
BASES: dict[str, dict[str, Any]] = {
    "state_machine": {"initial": "a", "outcomes": {"done": "success", "failure": "failure"}},
    "retry": {"times": 2},
    "timeout": {"seconds": 5},
    "guard": {"if": "t"},
    "switch": {"on_value": "x", "cases": {"a": 1}, "default": "b"},
    "for_each": {"items": "l", "item": "i"},
    "cooldown": {"seconds": 1},
    "foreign": {"behaviour": "py_trees.behaviours:Success"},
    "subtask": {"task": "tasks/fetch.yaml"},
    "force": {"as": "success"},
}
"""What a kind needs besides its children."""
LEAF = {"node": "flow/succeed"}
FAILS = {"node": "flow/fail", "with": {"code": "zz"}}
SETS = {"node": "flow/set", "with": {"value": 2}, "out": {"value": "x"}}


def shape_of(node: dict[str, Any]) -> type[BaseModel]:
    """Return the model of a node."""
    return KINDS[node["kind"]] if "kind" in node else model.Leaf


def of_kind(kind: str, **children: dict[str, Any]) -> dict[str, Any]:
    """Return a node of a kind, with these children as far as it holds some."""
    node: dict[str, Any] = {"kind": kind, **BASES.get(kind, {})}
    keys = keys_of(KINDS[kind])
    given = children or {"a": LEAF, "b": FAILS}
    if kind == "state_machine":
        given = {name: {"on": {"success": "done", "failure": "failure"}, **child} for name, child in given.items()}
    if kind == "foreign":
        return node  # whether a class takes children is known when it is made
    if "children" in keys:
        node["children"] = given
    elif "child" in keys:
        node["child"] = dict(itertools.islice(given.items(), 1))
    return node


def bound(manifest: Manifest) -> dict[str, Any]:
    """Return a leaf with each parameter and port given something."""
    usual = {"int": 1, "float": 0.5, "bool": True, "str": "home"}
    given = {name: usual.get(p.type, [0.1, 0.2, 0.3]) for name, p in manifest.parameters.items() if p.required}
    node: dict[str, Any] = {"node": manifest.id, **({"with": given} if given else {})}
    for key, ports in (("in", manifest.inputs), ("out", manifest.outputs)):
        if ports:
            node[key] = {port: f"v {port}" if key == "out" else "f" for port in ports}
    return node


def around(node: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield a node as the root, and as a child of kinds that do most with their children."""
    yield node
    if not {"success", "failure"} & set(node.get("on", ())):
        yield of_kind("sequence", a=node, b=SETS)
    yield of_kind("state_machine", a=node, b=LEAF)
    yield of_kind("parallel", a=node, b=SETS, c=FAILS)
    yield of_kind("retry", a=of_kind("guard", a=node))


def document(root: dict[str, Any], **more: Any) -> dict[str, Any]:
    """Return a task with some variables."""
    data = {
        "x": {"type": "int", "value": 1},
        "l": {"type": "list[int]", "value": [1, 2]},
        "t": {"type": "bool", "value": True},
        "f": {"type": "Any", "value": None},
    }
    return {"grip": 1, "name": "made", "data": data, "root": root, **more}


def systematic() -> Iterator[dict[str, Any]]:
    """Yield every kind with every value of every key, and every built-in leaf in several ways, in several places."""
    for kind in model.KINDS:
        for key in (*keys_of(KINDS[kind]), "x-note"):
            for value in VALUES[key]:
                for node in around({**of_kind(kind), key: value}):
                    yield document(node)
    for manifest in CATALOG:
        leaf = bound(manifest)
        written = {name: "Any" for name in leaf.get("out", {}).values()}
        for more in (
            {},
            {"precondition": "x < 1"},
            {"meaning": {"failure": "success"}},
            {"meaning": {"success": "failure"}},
        ):
            for node in around({**leaf, **more}):
                made = document(node)
                made["data"] |= written
                yield made
        yield document({"node": manifest.id})
        yield document(
            {"node": manifest.id, "with": {"arm": "zz", "hand": "zz"}, "in": {"zz": "x"}, "out": {"zz": "x"}}
        )
    for key in ("on", "precondition", "with", "in", "out", "meaning"):
        for value in VALUES[key]:
            for leaf in (LEAF, FAILS, SETS, {"node": "no/such"}):
                for node in around({**leaf, key: value}):
                    yield document(node)
    for variables in VARIABLES:
        for key in ("inputs", "outputs", "data"):
            made = document(SETS)
            yield (
                {**made, "data": {**made["data"], **variables}}
                if key == "data"
                else {**made, "data": {}, key: variables}
            )
    for outcomes in VALUES["outcomes"]:
        yield document(of_kind("sequence"), outcomes=outcomes)


def _with_keys(node: dict[str, Any]) -> st.SearchStrategy[dict[str, Any]]:
    keys = [key for key in (*keys_of(shape_of(node)), "x-note") if VALUES[key]]
    some = st.lists(st.sampled_from(keys), max_size=4, unique=True)
    chosen = some.flatmap(lambda names: st.fixed_dictionaries({name: st.sampled_from(VALUES[name]) for name in names}))
    return chosen.map(lambda more: {**node, **more})


def _containers(nodes: st.SearchStrategy[dict[str, Any]]) -> st.SearchStrategy[dict[str, Any]]:
    children = st.dictionaries(st.sampled_from(["a", "b", "c", "zz"]), nodes, min_size=1, max_size=3)
    kinds = st.sampled_from([kind for kind in model.KINDS if kind not in ("foreign", "subtask")])
    made = st.builds(lambda kind, children: of_kind(kind, **children), kinds, children)
    return made.flatmap(_with_keys)


_LEAVES = [LEAF, FAILS, SETS, *(bound(manifest) for manifest in CATALOG)]
_LEAVES += [of_kind(kind) for kind in ("foreign", "subtask")]
nodes = st.recursive(st.sampled_from(_LEAVES).flatmap(_with_keys), _containers, max_leaves=7)
documents = nodes.map(document)
"""Any nesting of them."""
