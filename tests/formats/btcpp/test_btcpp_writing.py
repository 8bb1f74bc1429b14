"""Tasks as BT.CPP's XML: what is written holds to its own model and comes back; the rest is refused by name."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grip_bt.base.errors import NotExpressibleError
from grip_bt.formats.btcpp import from_xml, to_xml
from grip_bt.task import dumps
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.model import Task

CATALOG = Catalog.builtin().with_manifests(
    [
        Manifest.model_validate(
            {
                "id": "test/work",
                "doc": "d",
                "implementation": "a:B",
                "parameters": {
                    "speed": {"type": "float", "default": 1.0, "doc": "how fast"},
                    "mode": {"type": "str", "default": ""},
                    "on": {"type": "bool", "default": False},
                    "list": {"type": "list[int]", "default": []},
                },
                "inputs": {"goal": {"type": "int", "required": False}},
                "outputs": {"found": {"type": "int"}, "word": {"type": "str"}},
            }
        ),
        Manifest.model_validate(
            {
                "id": "test/tell",
                "doc": "d",
                "implementation": "a:B",
                "inputs": {"word": {"type": "str"}, "count": {"type": "int", "required": False}},
                "outputs": {"count": {"type": "int"}},
            }
        ),
    ]
)
TEXT = st.text(st.characters(min_codepoint=32, max_codepoint=0x2FF), max_size=12)
NAMES = st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,6}( [a-z]{1,3})?", fullmatch=True)


def leaves() -> st.SearchStrategy[dict[str, Any]]:
    parameters = st.fixed_dictionaries(
        {},
        optional={
            "speed": st.floats(-1e6, 1e6),
            "mode": TEXT,
            "on": st.booleans(),
            "list": st.lists(st.integers(-9, 9), max_size=3),
        },
    )
    work = st.builds(lambda said: {"node": "test/work", **({"with": said} if said else {})}, parameters)
    waits = st.integers(0, 10**7).map(lambda ms: {"node": "flow/wait", "with": {"seconds": ms / 1000}})
    ends = st.sampled_from([{"node": "flow/succeed"}, {"node": "flow/fail"}])
    sets = st.one_of(
        st.booleans(), st.integers(-99, 99), TEXT.filter(lambda t: t.isascii() and not set(t) & set("'\"\\#"))
    )
    given_ = sets.map(
        lambda value: {"node": "flow/set", "with": {"value": value}, "out": {"value": f"a_{type(value).__name__}"}}
    )
    asked = st.sampled_from(["1 < 2", "true", "not 1 == 2", "1 < 2 and (true or 3 > 2)", "'a' == 'b'"])
    conditions = asked.map(lambda text: {"node": "flow/succeed", "precondition": text})
    return st.one_of(work, waits, ends, given_, conditions)


def containers(below: st.SearchStrategy[dict[str, Any]]) -> st.SearchStrategy[dict[str, Any]]:
    many = st.dictionaries(NAMES, below, min_size=1, max_size=4)
    one = st.dictionaries(NAMES, below, min_size=1, max_size=1)
    times = st.integers(1, 99)
    return st.one_of(
        st.builds(
            lambda kind, memory, children: {
                "kind": kind,
                **({} if memory else {"memory": False}),
                "children": children,
            },
            st.sampled_from(["sequence", "fallback"]),
            st.booleans(),
            many,
        ),
        st.builds(
            lambda policy, children: {"kind": "parallel", "cancel": "join", **policy, "children": children},
            st.sampled_from([{}, {"policy": "any"}]),
            st.dictionaries(NAMES, below, min_size=2, max_size=4),
        ),
        st.dictionaries(NAMES, below, min_size=2, max_size=4).flatmap(prompt),
        st.builds(lambda n, child: {"kind": "retry", "times": n, "child": child}, times, one),
        st.builds(lambda n, child: {"kind": "repeat", "times": n, "child": child}, times, one),
        st.builds(lambda child: {"kind": "repeat", "child": child}, one),
        st.builds(
            lambda ms, child: {"kind": "timeout", "seconds": ms / 1000, "child": child}, st.integers(1, 10**6), one
        ),
        st.builds(lambda child: {"kind": "invert", "child": child}, one),
        st.builds(
            lambda end, child: {"kind": "force", "as": end, "child": child},
            st.sampled_from(["success", "failure"]),
            one,
        ),
    )


def prompt(children: dict[str, Any]) -> st.SearchStrategy[dict[str, Any]]:
    def made(successes: int, failures: int) -> dict[str, Any]:
        least = min(failures, len(children) - successes + 1)
        rules = [{"at_least": successes, "then": "success"}, {"at_least": least, "ends": "failure", "then": "failure"}]
        return {"kind": "parallel", "prompt": True, "rules": rules, "children": children}

    count = st.integers(1, len(children))
    return st.builds(made, count, count)


def described(node: dict[str, Any], doc: str) -> dict[str, Any]:
    return {**node, "doc": doc} if doc.strip() == doc and doc else node


NODES = st.recursive(leaves(), lambda below: containers(st.builds(described, below, TEXT)), max_leaves=12)


def task(root: dict[str, Any], **more: Any) -> Task:
    return Task.model_validate({"grip": 1, "name": "tested", "root": root, **more})


def with_data(root: dict[str, Any]) -> Task:
    """Declare the variables that are written."""
    text = dumps(task(root))
    data = {f"a_{kind}": kind for kind in ("bool", "int", "str") if f"value: a_{kind}" in text}
    return task(root, **({"data": data} if data else {}))


@settings(max_examples=int(os.environ.get("GRIP_FUZZ_TASKS", "40")), deadline=None)
@given(NODES)
def test_a_task_comes_back_as_it_was(root: dict[str, Any]) -> None:
    before = with_data(root)
    written = to_xml(before, CATALOG)
    check_against_model(written)
    after = from_xml(written, CATALOG).task
    assert dict(after.data) == dict(before.data)
    assert unordered(after.model_copy(update={"data": before.data})) == unordered(before)
    assert to_xml(after, CATALOG) == written


def unordered(one: Task) -> list[str]:
    """Return a task's lines without what says that the children of a parallel have an order, as all have in BT.CPP."""
    return [line for line in dumps(one).splitlines() if line.strip() != "order: declared"]


BUILTIN_PORTS = {
    "Parallel": {"success_count", "failure_count"},
    "ParallelAll": {"max_failures"},
    "RetryUntilSuccessful": {"num_attempts"},
    "Repeat": {"num_cycles"},
    "Timeout": {"msec"},
    "Sleep": {"msec"},
    "Script": {"code"},
    "ScriptCondition": {"code"},
    **{f"Switch{n}": {"variable", *(f"case_{i}" for i in range(1, n + 1))} for n in range(2, 7)},
    **{tag: set() for tag in ("Sequence", "ReactiveSequence", "Fallback", "ReactiveFallback", "Inverter")},
    **{tag: set() for tag in ("ForceSuccess", "ForceFailure", "AlwaysSuccess", "AlwaysFailure")},
}
DECORATORS = {"RetryUntilSuccessful", "Repeat", "Timeout", "Inverter", "ForceSuccess", "ForceFailure"}
ANYWHERE = {"name", "_failureIf", "_description"}


def check_against_model(text: str) -> None:
    """Hold a file to BT.CPP's rules: format, one root per tree, children by kind, and ports that the model has."""
    root = ET.fromstring(text)
    assert root.tag == "root"
    assert root.get("BTCPP_format") == "4"
    trees = {tree.get("ID"): tree for tree in root.findall("BehaviorTree")}
    assert root.get("main_tree_to_execute") in trees
    models: dict[str, dict[str, str]] = {}
    for model in root.findall("TreeNodesModel/*"):
        assert model.tag == "Action"
        models[model.attrib["ID"]] = {port.attrib["name"]: port.tag for port in model}
        assert all(port.get("type") and port.tag in ("input_port", "output_port", "inout_port") for port in model)
    used = set()
    for tree in trees.values():
        assert len(tree) == 1
        for node in tree.iter():
            if node is tree:
                continue
            ports = BUILTIN_PORTS.get(node.tag, models.get(node.tag))
            assert ports is not None, f"<{node.tag}> is neither BT.CPP's nor in the model"
            assert set(node.attrib) - ANYWHERE <= set(ports)
            if node.tag in models:
                used.add(node.tag)
                assert not len(node)
                outputs = [p for p, kind in models[node.tag].items() if kind != "input_port" and p in node.attrib]
                assert all(node.attrib[port].startswith("{") for port in outputs)
            if node.tag in DECORATORS:
                assert len(node) == 1
    assert used == set(models)


def test_ports_keys_and_switches_come_back() -> None:
    root = {
        "kind": "sequence",
        "children": {
            "look": {
                "node": "test/work",
                "with": {"speed": 0.5, "list": [1, 2]},
                "out": {"found": "n", "word": "word"},
            },
            "tell": {"node": "test/tell", "in": {"word": "word", "count": "n"}, "out": {"count": "n"}},
            "turn": {
                "kind": "switch",
                "on_value": "word",
                "cases": {"a": "left", "b": "right"},
                "default": "c",
                "memory": False,
                "children": {name: {"node": "test/work", "in": {"goal": "n"}} for name in "abc"},
            },
            "if": {"node": "test/work", "precondition": "n > 1 and (not word == 'no')"},
        },
    }
    before = task(root, data={"n": "int", "word": "str"})
    written = to_xml(before, CATALOG)
    check_against_model(written)
    assert dumps(from_xml(written, CATALOG).task) == dumps(before)
    assert '<test__tell name="tell" word="{word}" count="{n}" />' in written
    assert '<inout_port name="count" type="int" />' in written
    assert '<input_port name="speed" type="double" default="1.0">how fast</input_port>' in written
    assert "_failureIf=\"!(n &gt; 1 &amp;&amp; !(word == 'no'))\"" in written


def test_computed_values_are_scripts_and_come_back() -> None:
    def compute(expression: str, out: str, **inputs: str) -> dict[str, Any]:
        return {"node": "flow/compute", "with": {"expression": expression}, "in": inputs, "out": {"value": out}}

    root = {
        "kind": "sequence",
        "children": {
            "first": {"node": "flow/set", "with": {"value": 2}, "out": {"value": "n"}},
            "more": compute("a * (a + 1)", "n", a="n"),
            "both": compute("a > 1 and (not a == 3)", "good", a="n"),
            "copy": compute("a", "other", a="n"),
        },
    }
    before = task(root, data={"n": "int", "good": "bool", "other": "int"})
    written = to_xml(before, CATALOG)
    assert 'code="n := n * (n + 1)"' in written
    assert 'code="good := n &gt; 1 &amp;&amp; !(n == 3)"' in written
    assert "TreeNodesModel" not in written
    assert dumps(from_xml(written, CATALOG).task) == dumps(before)


WORK = {"node": "test/work"}
REFUSALS: list[tuple[dict[str, Any], dict[str, Any], str]] = [
    ({"kind": "cooldown", "seconds": 1, "child": {"a": WORK}}, {}, "/: a cooldown"),
    ({"kind": "timeout", "seconds": 1, "child_first": True, "child": {"a": WORK}}, {}, "/: a timeout"),
    ({**WORK, "with": {"mode": "{x}"}}, {}, "`mode` ('{x}' has no text that is read as str)"),
    (
        {"kind": "timeout", "seconds": 0.0005, "child": {"a": WORK}},
        {},
        "0.0005 s, which isn't a whole number of milliseconds",
    ),
    ({**WORK, "precondition": "len([1]) > 0"}, {}, "`len([1])` has no equivalent"),
    ({**WORK, "precondition": "0.5 == 0.5"}, {}, "BT.CPP takes numbers within 1.2e-7 for equal"),
    ({**WORK, "out": {"found": "n"}}, {"outputs": {"n": "int"}}, "outputs of a task"),
]


LOWERED: list[tuple[dict[str, Any], dict[str, Any]]] = [
    ({"kind": "guard", "if": "true", "child": {"a": WORK}}, {}),
    ({"kind": "sequence", "children": {"a": {"kind": "sequence", "children": {}}}}, {}),
    ({"kind": "parallel", "children": {"a": WORK, "b": WORK}}, {}),
    ({"kind": "fallback", "exits": {"b.success": "failure"}, "children": {"b": WORK}}, {}),
    ({**WORK, "out": {"found": "n"}}, {"data": {"n": {"type": "int", "value": 1}}}),
    ({"kind": "switch", "on_value": "7 % 3", "cases": {"a": [1, 2]}, "children": {"a": WORK}}, {}),
]


@pytest.mark.parametrize(("root", "more"), LOWERED, ids=[str(root)[:40] for root, _ in LOWERED])
def test_what_no_element_says_is_written_by_several(root: dict[str, Any], more: dict[str, Any]) -> None:
    made = from_xml(to_xml(task(root, **more), CATALOG), Catalog.builtin())
    assert made.task.name == "tested"


@pytest.mark.parametrize(("root", "more", "message"), REFUSALS, ids=[message for *_, message in REFUSALS])
def test_what_has_no_equal_is_refused_by_name(root: dict[str, Any], more: dict[str, Any], message: str) -> None:
    with pytest.raises(NotExpressibleError) as refused:
        to_xml(task(root, **more), CATALOG)
    assert message in str(refused.value)
