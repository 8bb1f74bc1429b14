"""Hypothesis strategies for tasks: any shape, any text, any literal; not necessarily valid tasks."""

from __future__ import annotations

from hypothesis import strategies as st

from grip_bt.task import (
    Cooldown,
    Fallback,
    Force,
    ForEach,
    Foreign,
    Guard,
    Invert,
    Leaf,
    Loop,
    Parallel,
    Repeat,
    Retry,
    Sequence,
    StateMachine,
    Subtask,
    Switch,
    Task,
    Timeout,
    Variable,
)

names = st.from_regex(r"\A[A-Za-z_][A-Za-z0-9_ -]{0,8}\Z")
tricky = st.sampled_from(
    ["", "null", "on", "yes", "1", "1e5", "0x1F", ".inf", "- a", "a: b", "a #b", "#", "a\n", "a\n\nb", " a", "a ",
     "'", '"', "[a]", "{a}", "a, b", "---", "...", "~", "\x85", "\u2028", "\ufeff", "é", "!a", "&a", "*a", "|", ">",
     "%a", "@a", "`a", "a:", ":a", "a\tb", "true", "word " * 40, "\n" * 3, "a\n b\nc  \n", "?", "? a", "=", "<<"]
)  # fmt: skip
texts = tricky | st.text(
    st.characters(exclude_categories=["Cs"]), max_size=30
) | st.from_regex(r"\A[a-z,.:#' -]{0,160}\Z")  # fmt: skip
meanings = st.sampled_from(["success", "failure"])
scalars = st.none() | st.booleans() | st.integers(-(2**63) + 1, 2**63 - 1) | st.floats(allow_nan=False) | texts
literals = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(texts, inner, max_size=3),
    max_leaves=6,
)
free = st.dictionaries(st.from_regex(r"\Ax-[a-z#: ]{0,6}\Z"), literals, max_size=2)
variables = texts | st.builds(Variable, type=texts, doc=texts) | st.builds(
    Variable, type=texts, value=literals
)  # fmt: skip
bindings = st.dictionaries(texts, texts, max_size=3)
common = {"doc": texts, "precondition": texts, "on": bindings, "x": free}
own = {
    **common,
    "data": st.dictionaries(names, variables, max_size=2),
    "outcomes": st.dictionaries(names, meanings, max_size=2),
}
leaves = st.fixed_dictionaries(
    {"node": texts},
    optional={
        **common,
        "with": st.dictionaries(texts, literals, max_size=3),
        "in": bindings,
        "out": bindings,
        "meaning": st.dictionaries(texts, meanings, max_size=2),
    },
).map(Leaf.model_validate)


rules = st.fixed_dictionaries(
    {"then": texts},
    optional={
        "when": st.dictionaries(names, texts | st.lists(texts, max_size=2), max_size=2),
        "at_least": st.integers(1, 9),
        "ends": meanings,
    },
)


def _made(model, kind, fields, extra=None):
    optional = {**own, **(extra or {})}
    return st.fixed_dictionaries(
        {"kind": st.just(kind), **fields},
        optional={key: value for key, value in optional.items() if key not in fields},
    ).map(model.model_validate)


_foreign = st.fixed_dictionaries(
    {"kind": st.just("foreign"), "behaviour": st.just("a.b:C.d")},
    optional={**common, "args": st.dictionaries(texts, literals, max_size=2)},
).map(Foreign.model_validate)


_subtasks = st.fixed_dictionaries(
    {"kind": st.just("subtask"), "task": texts.filter(bool)},
    optional={
        **common,
        "with": st.dictionaries(texts, literals, max_size=2),
        "in": bindings,
        "out": bindings,
        "meaning": st.dictionaries(texts, meanings, max_size=2),
    },
).map(Subtask.model_validate)


def _containers(nodes):
    children = st.dictionaries(names, nodes, max_size=3)
    child = st.dictionaries(names, nodes, min_size=1, max_size=1)
    memory = {"memory": st.booleans(), "exits": bindings}
    exits = {"exits": bindings}
    seconds = st.floats(0.001, 1e6) | st.integers(1, 100).map(float)
    return st.one_of(
        _made(Sequence, "sequence", {"children": children}, memory),
        _made(Fallback, "fallback", {"children": children}, memory),
        _made(
            Parallel,
            "parallel",
            {"children": children},
            {
                "policy": st.sampled_from(["all", "any"]),
                "cancel": st.sampled_from(["halt", "ask"]),
                "order": st.sampled_from([None, "declared"]),
                "rules": st.lists(rules, max_size=2),
                "wait_for": st.sampled_from(["all", "any", 2, ["a"]]),
                "exits": bindings,
            },
        ),
        _made(
            Parallel,
            "parallel",
            {"children": children},
            {"policy": st.sampled_from(["all", "any"]), "exits": bindings, "rules": st.lists(rules, max_size=1)},
        ).flatmap(
            lambda node: st.sampled_from(["retick", "prompt"]).map(lambda key: node.model_copy(update={key: True}))
        ),
        _made(
            StateMachine,
            "state_machine",
            {
                "initial": texts,
                "outcomes": st.dictionaries(names, meanings, min_size=1, max_size=2),
                "children": st.dictionaries(names, nodes, min_size=1, max_size=3),
            },
        ),
        _made(Retry, "retry", {"times": st.integers(1, 9), "child": child}, exits),
        _made(Repeat, "repeat", {"child": child}, {"times": st.integers(1, 9), **exits}),
        _made(Timeout, "timeout", {"seconds": seconds, "child": child}, exits),
        _made(Guard, "guard", {"if": texts, "child": child}, exits),
        _made(
            Switch,
            "switch",
            {
                "on_value": texts,
                "cases": st.dictionaries(texts, scalars | st.lists(scalars, max_size=2), max_size=2),
                "children": st.dictionaries(names, nodes, min_size=1, max_size=3),
            },
            {"default": texts, **memory},
        ),
        _made(ForEach, "for_each", {"items": texts, "item": names, "child": child, "data": st.just({})}, exits),
        _made(Loop, "loop", {"child": child}, {"while": texts, "times": st.integers(1, 9), **exits}),
        _made(Cooldown, "cooldown", {"seconds": seconds, "child": child}, exits),
        _foreign,
        _subtasks,
        _made(Invert, "invert", {"child": child}, exits),
        _made(Force, "force", {"as": meanings, "child": child}, exits),
    )


nodes = st.recursive(leaves, _containers, max_leaves=6)


def _with_ports(data):
    """Take what stands in `data` out of the ports, since each variable is declared once."""
    data["inputs"] = {k: v for k, v in data.get("inputs", {}).items() if k not in data.get("data", {})}
    taken = {**data.get("data", {}), **data["inputs"]}
    data["outputs"] = {k: v for k, v in data.get("outputs", {}).items() if k not in taken}
    return data


tasks = st.fixed_dictionaries(
    {"grip": st.just(1), "name": texts, "root": nodes},
    optional={
        "doc": texts,
        "x": free,
        "data": st.dictionaries(names, variables, max_size=3),
        "inputs": st.dictionaries(names, variables, max_size=2),
        "outputs": st.dictionaries(names, variables, max_size=2),
        "outcomes": st.dictionaries(names, meanings, min_size=1, max_size=3),
    },
).map(_with_ports).map(Task.model_validate)  # fmt: skip
