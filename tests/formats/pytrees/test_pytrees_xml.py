"""py_trees' XML: a task comes back from it as it was, py_trees builds the same tree of it, the rest is refused."""

from __future__ import annotations

import itertools
import os
import time
from pathlib import Path
from random import Random
from typing import Any, ClassVar

import py_trees
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from py_trees import behaviours, timers
from py_trees.parsers.behaviour_tree_xml import parse_behaviour_tree_xml
from py_trees.ports import PortsMixin
from random_trees import make_tree
from timed import ManualClock

from grip_bt.base.errors import DocumentError, GripError, NotExpressibleError
from grip_bt.cli.__main__ import main
from grip_bt.formats.blackboard import text_of_value, value_of_text
from grip_bt.formats.pytrees import from_xml, to_task, to_xml
from grip_bt.task import Task
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.validation import validate

TASKS = int(os.environ.get("GRIP_FUZZ_TASKS", "200"))
FIRST = int(os.environ.get("GRIP_FUZZ_SEED", "0"))
BUILTIN = Catalog.builtin()
PORTS = Catalog.builtin().with_manifests(
    [
        Manifest(id="t/make", doc="d", implementation="m:Writer", outputs={"output": {"type": "float"}}),
        Manifest(
            id="t/use",
            doc="d",
            implementation="m:Reader",
            inputs={"input": {"type": "float"}},
            parameters={
                "text": {"type": "str", "default": ""},
                "flag": {"type": "bool", "default": False},
                "many": {"type": "list[int]", "default": []},
                "maybe": {"type": "float | None", "default": None},
            },
        ),
    ]
)


class Succeed(PortsMixin, behaviours.Success):
    INPUT_PORTS: ClassVar[dict[str, Any]] = {}
    OUTPUT_PORTS: ClassVar[dict[str, Any]] = {}

    def __init__(self, name: str, behaviour_class_name: str):
        behaviours.Success.__init__(self, name)


class Fail(PortsMixin, behaviours.Failure):
    INPUT_PORTS: ClassVar[dict[str, Any]] = {}
    OUTPUT_PORTS: ClassVar[dict[str, Any]] = {}

    def __init__(self, name: str, behaviour_class_name: str):
        behaviours.Failure.__init__(self, name)


class Wait(PortsMixin, timers.Timer):
    INPUT_PORTS: ClassVar[dict[str, Any]] = {}
    OUTPUT_PORTS: ClassVar[dict[str, Any]] = {}

    def __init__(self, name: str, behaviour_class_name: str, seconds: str):
        timers.Timer.__init__(self, name, float(seconds))


REGISTRY = {"flow.succeed": Succeed, "flow.fail": Fail, "flow.wait": Wait}


def task_of(root: dict[str, Any], **more: Any) -> Task:
    return Task.model_validate({"grip": 1, "name": "t", "root": root, **more})


def xml(inside: str, before: str = "", more: str = "") -> str:
    return f'{before}<root main_tree_to_execute="main"><BehaviorTree ID="main">{inside}</BehaviorTree>{more}</root>'


def statuses(root: py_trees.behaviour.Behaviour) -> list[str]:
    return [node.status.name for node in root.iterate()]


def test_a_task_comes_back_as_it_was() -> None:
    for seed in range(FIRST, FIRST + TASKS):
        task = to_task(make_tree(Random(seed), written=True), "t").task
        assert from_xml(to_xml(task, BUILTIN), BUILTIN).task == task, f"seed {seed}"


def test_py_trees_builds_the_same_tree_of_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    clock, readings, file = ManualClock(), itertools.count(), tmp_path / "tree.xml"
    for name in ("time", "monotonic"):
        monkeypatch.setattr(time, name, lambda: clock.now() + next(readings) * 1e-9)
    for seed in range(FIRST, FIRST + TASKS):
        tree = make_tree(Random(seed), written=True)
        file.write_text(to_xml(to_task(tree, "t").task, BUILTIN))
        built = parse_behaviour_tree_xml(str(file), node_registry=REGISTRY)
        for tick in range(10):
            tree.tick_once()
            built.tick_once()
            assert statuses(built) == statuses(tree), f"seed {seed}, tick {tick}"
            clock.advance(1)


def test_keys_become_variables_of_the_ports_types_and_sub_trees_have_their_own() -> None:
    # the example of py_trees' documentation
    sub = """<BehaviorTree ID="MySubtree" spare="{fallback}"><Sequence>
        <Reader name="MyReader" input="{input_key}"/><Writer name="w" output="{transfer_key}"/>
        <Reader name="r" input="{transfer_key}"/><Reader name="s" input="{spare}"/></Sequence></BehaviorTree>"""
    root = """<Sequence><Writer output="{some_key}" name="WriterMain"/>
        <SubTree ID="MySubtree" name="Subtree1" input_key="{some_key}"/>
        <SubTreePlus ID="MySubtree" name="Subtree2" input_key="2.5"/></Sequence>"""
    task = from_xml(xml(root, more=sub), PORTS).task
    assert list(task.root.children) == ["WriterMain", "Subtree1", "Subtree2"]
    one, two = task.root.children["Subtree1"].children, task.root.children["Subtree2"].children
    assert [one[name].in_.get("input") for name in ("MyReader", "r", "s")] == [
        "some_key",
        "Subtree1_transfer_key",
        "fallback",
    ]
    assert one["w"].out["output"] == "Subtree1_transfer_key"
    assert two["r"].in_["input"] == "Subtree2_transfer_key"
    given = task.data[two["MyReader"].in_["input"]]
    assert (given.type, given.value) == ("float", 2.5)
    assert task.data["some_key"] == "float"
    assert not [issue for issue in validate(task, PORTS).issues if "undeclared" in issue.code or "type" in issue.code]


@settings(max_examples=60, deadline=None)
@given(st.text(), st.booleans(), st.lists(st.integers(-(2**40), 2**40)), st.none() | st.floats(), st.text())
def test_parameters_come_back_or_are_refused(text: str, flag: bool, many: list[int], maybe: Any, doc: str) -> None:
    given = {"text": text, "flag": flag, "many": many, "maybe": maybe}
    task = task_of({"node": "t/use", "with": given, "in": {"input": "v"}, "doc": doc}, data={"v": "float"}, doc=doc)
    try:
        written = to_xml(task, PORTS)
    except NotExpressibleError:
        return
    assert from_xml(written, PORTS).task.root.with_ == given


@pytest.mark.parametrize(
    ("root", "what"),
    [
        (
            {"kind": "sequence", "children": {"a": {"node": "flow/succeed", "precondition": "1 > 2"}}},
            "a: `precondition`",
        ),
        ({"kind": "guard", "if": "1 > 2", "child": {"a": {"node": "flow/fail"}}}, "/: a guard"),
        ({"kind": "parallel", "cancel": "join", "children": {}}, "this parallel"),
        ({"kind": "sequence", "data": {"v": "int"}, "children": {}}, "`data`"),
        (
            {"kind": "sequence", "outcomes": {"x": "success"}, "children": {}, "on": {"x": "success"}},
            "outcomes of its own",
        ),
        (
            {"kind": "sequence", "children": {"a": {"node": "flow/fail"}}, "exits": {"a.failure": "success"}},
            "`exits`",
        ),
        ({"node": "flow/fail", "with": {"message": "{braces}"}}, "`message`"),
        ({"node": "flow/fail", "meaning": {"failure": "success"}, "on": {"failure": "failure"}}, "`meaning`"),
    ],
)
def test_what_the_xml_cannot_say_is_refused_by_name(root: dict[str, Any], what: str) -> None:
    with pytest.raises(NotExpressibleError, match=what):
        to_xml(task_of(root), BUILTIN)


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("<root>", "isn't well-formed XML"),
        (xml("<flow.fail/>", '<!DOCTYPE r [<!ENTITY a "aaa">]>\n'), r"t\.xml:1: it declares an entity"),
        (xml("<a>" * 200 + "</a>" * 200), "nested more than 120 deep"),
        (xml("<Sequence memry='true'/>"), "no attribute 'memry'; did you mean 'memory'"),
        (xml("<Sequence memory='yes'/>"), "'yes' can't be read as bool"),
        (xml("\n\n<Parallel policy='succes_on_all'/>"), r"t\.xml:3: .*'succes_on_all'; did you mean 'success_on_all'"),
        (xml("<Parallel policy='success_on_selected'/>"), "success_on_selected"),
        (xml("<OneShot policy='x'><flow.fail/></OneShot>"), "OneShot: a task read from XML has none"),
        (xml("<Retry><flow.fail/></Retry>"), "needs num_failures"),
        (xml("<Retry num_failures='{n}'><flow.fail/></Retry>"), "is a variable; it has to be a constant"),
        (xml("<Inverter/>"), "needs one node inside, and has 0"),
        (xml("<flow.fial/>"), "the catalogue has no such node.*flow.fail"),
        (xml("<flow.fail code='{k}'/>"), "takes only a literal for 'code'"),
        (xml("<flow.fail code='a{k}'/>"), "isn't a key"),
        (xml("<flow.fail><flow.fail/></flow.fail>"), "is a leaf"),
        (xml("<SubTree ID='main'/>"), "holds itself"),
        (xml("<SubTree ID='other'/>"), "there is no tree 'other'"),
        (xml("<flow.fail/>", more="<Include src='../x.xml'/>"), "no file '../x.xml' in the folder"),
        (xml("<flow.fail/>").replace('execute="main"', 'execute="mian"'), "no <BehaviorTree ID='mian'>"),
    ],
)
def test_what_a_task_cannot_say_is_refused_with_its_line(text: str, what: str) -> None:
    with pytest.raises(DocumentError, match=what):
        from_xml(text, BUILTIN, "t.xml")


def test_sub_trees_in_sub_trees_do_not_explode() -> None:
    trees = "".join(
        f"<BehaviorTree ID='t{i}'><Sequence>{f'<SubTree ID={chr(39)}t{i + 1}{chr(39)}/>' * 4}</Sequence></BehaviorTree>"
        for i in range(30)
    )
    with pytest.raises(DocumentError, match="more than 20000 nodes"):
        from_xml(xml("<SubTree ID='t0'/>", more=trees + "<BehaviorTree ID='t30'><flow.fail/></BehaviorTree>"), BUILTIN)


def test_included_files_are_read_from_the_same_folder_only(tmp_path: Path) -> None:
    inner = tmp_path / "inner"
    inner.mkdir()
    (tmp_path / "secret.xml").write_text("<root><BehaviorTree ID='secret'><flow.fail/></BehaviorTree></root>")
    (inner / "more.xml").write_text(
        "<root><Include file='more.xml'/><BehaviorTree ID='b'><flow.fail/></BehaviorTree></root>"
    )
    text = xml("<SubTree ID='b'/>", more="<Include file='more.xml'/>")
    assert from_xml(text, BUILTIN, folder=inner).task.root.node == "flow/fail"
    for outside in ("../secret.xml", str(tmp_path / "secret.xml")):
        with pytest.raises(DocumentError, match="there is no file"):
            from_xml(text.replace("more.xml", outside), BUILTIN, folder=inner)


def test_the_command_writes_it(tmp_path: Path) -> None:
    task, out = tmp_path / "t.yaml", tmp_path / "t.xml"
    task.write_text("grip: 1\nname: one & only\nroot: {node: flow/fail, doc: 'a -- b', with: {code: '<\"&>'}}\n")
    assert main(["convert", str(task), "--to", "pytrees-xml", "-o", str(out)]) == 0
    assert from_xml(out.read_text(), BUILTIN).task.root.with_ == {"code": '<"&>'}
    assert "<!-- a - - b -->" in out.read_text()


def test_a_mutated_file_is_a_task_or_a_typed_error() -> None:
    words = ["<", "/>", '"', "{", "}", "&", "ID", "9" * 400, "-1", "nan", "1e999", "\x00", "ü", "none", "Sequence", " "]
    tasks = errors = 0
    for seed in range(FIRST, FIRST + 3 * TASKS):
        random = Random(seed)
        text = to_xml(to_task(make_tree(random, 3, written=True), "t").task, BUILTIN)
        for _ in range(random.randint(1, 3)):
            at = random.randrange(len(text))
            text = text[:at] + random.choice(words) + text[at + random.choice((0, 0, 1, 3)) :]
        try:
            from_xml(text, BUILTIN)
            tasks += 1
        except GripError:
            errors += 1
    assert min(tasks, errors) > TASKS // 20


@pytest.mark.parametrize(
    ("value", "type_name", "text"),
    [(1, "float", "1.0"), ([1, 2.5], "list[float]", "1.0, 2.5"), (3, "float | None", "3.0"), (3, "int", "3")],
)
def test_a_whole_number_is_written_as_the_float_that_is_wanted(value: Any, type_name: str, text: str) -> None:
    assert text_of_value(value, type_name, as_json=False) == text
    assert value_of_text(text, type_name) == value


def test_a_whole_number_beyond_every_float_is_refused() -> None:
    with pytest.raises(ValueError, match="has no text that is read as float"):
        text_of_value(2**53 + 1, "float")
