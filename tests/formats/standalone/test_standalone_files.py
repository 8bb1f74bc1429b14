"""Exported files are the golden ones, run on their own, are formatted, and hold nothing of a task but literals."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path
from typing import Any

import py_trees
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from py_trees.common import Status

from grip_bt.app.project.catalogue import project_catalog
from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.base.errors import NotExpressibleError
from grip_bt.base.values import Pose
from grip_bt.cli.__main__ import main
from grip_bt.formats.standalone import export
from grip_bt.task import Task, read
from grip_bt.task.catalog import Catalog

GOLDEN = Path(__file__).parents[2] / "golden" / "standalone"
EXAMPLE = Path(__file__).parents[3] / "examples" / "tasks" / "reactive_pick.yaml"
TASKS = ("plain_steps", "labelled_ends")


def exported(file: Path) -> str:
    return export(read(file).task, Catalog.builtin())


def of(root: dict[str, Any], **task: Any) -> str:
    return export(Task.model_validate({"grip": 1, "name": "t", "root": root, **task}), Catalog.builtin())


def ruff(*arguments: str, text: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "ruff", *arguments, "-"]
    return subprocess.run(command, input=text, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("name", TASKS)
def test_the_file_is_the_golden_one(name: str) -> None:
    assert exported(GOLDEN / f"{name}.yaml") == (GOLDEN / f"{name}.py").read_text()


@pytest.mark.parametrize(("name", "end"), [("plain_steps", "in"), ("labelled_ends", "done")])
def test_the_file_runs_on_its_own_and_needs_no_grip(name: str, end: str) -> None:
    code = f"import sys; sys.modules['grip_bt'] = None; exec(open({str(GOLDEN / f'{name}.py')!r}).read())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=600)
    assert (done.stdout.strip(), done.returncode) == (end, 0), done.stderr


@pytest.mark.parametrize("file", [*(GOLDEN / f"{name}.yaml" for name in TASKS), EXAMPLE], ids=lambda f: f.stem)
def test_the_command_writes_a_formatted_file_without_loose_ends(file: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.py"
    assert main(["convert", str(file), "--to", "pytrees-py", "-o", str(out)]) == 0
    text = out.read_text()
    assert ruff("format", "--isolated", text=text).stdout == text
    assert ruff("check", "--isolated", "--select", "E4,E7,E9,F,B,UP", text=text).stdout == "All checks passed!\n"


def test_plain_kinds_become_classes_of_py_trees_and_need_no_supporting_class() -> None:
    text = exported(GOLDEN / "plain_steps.yaml")
    classes = [node.name for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ClassDef)]
    assert classes == ["Log"]  # of the leaf that logs
    assert "grip_bt" not in text


def test_leaves_of_components_are_found_relative_to_the_file(tmp_path: Path) -> None:
    out = tmp_path / "out.py"
    main(["convert", str(EXAMPLE), "--to", "pytrees-py", "-o", str(out)])
    assert 'f"{HERE}/../' in out.read_text()
    made: dict[str, Any] = {"__name__": "exported", "__file__": str(out)}
    exec(compile(out.read_text(), str(out), "exec"), made)
    names = [type(node).__name__ for node in made["create_root"]().iterate()]
    assert "AntipodalGrasps" in names
    assert "MoveToGrasp" in names


def test_the_example_runs_from_its_file_with_parts_that_do_as_they_are_asked(tmp_path: Path) -> None:
    made: dict[str, Any] = {"__name__": "exported", "__file__": str(tmp_path / "out.py")}
    exec(compile(export(read(EXAMPLE).task, project_catalog(EXAMPLE), tmp_path), "out.py", "exec"), made)
    ends = []
    for run in (
        lambda s: s.runner.run().outcome,
        lambda s: made["run"](made["create_root"](), s.runner.context, 0.001),
    ):
        with open_session(EXAMPLE, RunOptions(robot="fake", journal=tmp_path / f"{len(ends)}.sqlite")) as session:
            ends.append(run(session))
    assert ends == ["cleared", "cleared"]


def test_no_two_things_of_a_file_have_one_name() -> None:
    leaf = {"node": "flow/log", "with": {"message": "x"}, "in": {"value": "list"}}
    names = ("root", "py_trees", "list", "class", "Log", "run", "Status", "a b", "a-b", "a_b", "_", "print")
    children = {name: {"kind": "sequence", "children": {name: leaf}} for name in names}
    text = of({"kind": "sequence", "children": children}, data={"list": "int", "a_b": "int", "copy": "int"})
    function = next(n for n in ast.parse(text).body if isinstance(n, ast.FunctionDef) and n.name == "create_root")
    targets = [n.targets[0].id for n in function.body if isinstance(n, ast.Assign)]
    assert len(set(targets)) == len(targets) == 3 + 1 + 2 * len(names)
    assert not {"py_trees", "list", "Log", "run", "Status", "copy", "print"} & set(targets)


@pytest.mark.parametrize("wrong", [{"with": {"code": float("inf")}}, {"with": {"message": "no code"}}])
def test_a_wrong_value_is_still_a_literal(wrong: dict[str, Any]) -> None:
    compile(of({"node": "flow/fail", **wrong}), "t.py", "exec")


@settings(max_examples=60, deadline=None)
@given(st.text(max_size=120), st.text(max_size=200), st.lists(st.floats() | st.text() | st.none(), max_size=4))
def test_texts_of_a_task_stay_texts(name: str, doc: str, values: list[Any]) -> None:
    said = ('""" + boom() + """', "'); boom(); ('", "{{ boom() }}", "\\", "a\nboom()", "#", "\r\nboom()", name, doc)
    children: dict[str, Any] = {
        f"n{number}": {"node": "flow/log", "doc": f"{text}\nboom()", "with": {"message": text}}
        for number, text in enumerate(said)
    }
    data = {"v": {"type": "Any", "value": values}}
    text = of({"kind": "sequence", "doc": doc, "children": children}, data=data, doc=doc, name=name)
    made: dict[str, Any] = {"__name__": "exported"}
    exec(compile(text, "t.py", "exec"), made)
    assert not any(isinstance(n, ast.Name) and n.id == "boom" for n in ast.walk(ast.parse(text)))
    root = made["create_root"]()
    assert [child.message for child in root.children] == list(said)
    assert root.name == name


@settings(max_examples=15, deadline=None)
@given(st.lists(st.text(st.characters(codec="ascii"), min_size=60, max_size=110), min_size=4, max_size=4))
def test_long_texts_keep_the_file_formatted(texts: list[str]) -> None:
    long = " and ".join(f"{name} + {number} > {number}" for number, name in enumerate(["count"] * 12))
    children = {
        "one": {"node": "flow/log", "doc": texts[0], "with": {"message": texts[1].replace("'", "").replace('"', "")}},
        "two": {"kind": "guard", "if": long, "child": {"in it": {"node": "flow/fail"}}},
        "three": {"node": "flow/succeed", "precondition": "count > 1 and count < 10 and count != 5 or count == 77"},
    }
    data = {"count": {"type": "int", "value": 1}, "words": {"type": "list[str]", "value": [t[:50] for t in "ab"]}}
    text = of({"kind": "sequence", "children": children}, data=data, doc=texts[2], name=texts[3])
    assert ruff("format", "--isolated", text=text).stdout == text


def test_what_has_no_equal_is_refused_by_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    from grip_bt.formats.standalone import builder

    asks = {"kind": "parallel", "cancel": "ask", "children": {"x": {"node": "flow/fail"}}}
    with pytest.raises(
        NotExpressibleError, match="odd: `cancel: ask` of a parallel can't be expressed exactly as a sta"
    ):
        of({"kind": "sequence", "children": {"odd": asks}})
    loop = {"kind": "loop", "times": 2, "child": {"x": {"node": "flow/fail"}}}
    monkeypatch.setattr(builder, "_ANSWERED", builder._ANSWERED - {"reached"})
    with pytest.raises(NotExpressibleError, match="odd: a loop, which asks for `reached`, can't be expressed exactly"):
        of({"kind": "sequence", "children": {"odd": loop}})


def test_a_setting_that_the_class_of_py_trees_does_not_have_takes_the_source_of_the_kind() -> None:
    children = {"x": {"node": "flow/fail"}}
    for setting in ({"prompt": True}, {"policy": "any"}, {"exits": {"x.failure": "success"}}):
        text = of({"kind": "parallel", "children": children, **setting})
        assert "class Parallel(Kind):" in text
        assert "py_trees.composites.Parallel(" not in text
    assert "py_trees.composites.Parallel(" in of({"kind": "parallel", "children": children})


def test_run_stops_what_still_runs_when_a_leaf_raises() -> None:
    made: dict[str, Any] = {"__name__": "exported"}
    exec(of({"kind": "parallel", "children": {"w": {"node": "flow/wait", "with": {"seconds": 9}}}}), made)
    root = made["create_root"]()

    class Broken(py_trees.behaviour.Behaviour):
        def update(self) -> Status:
            raise RuntimeError("broken")

    root.add_child(Broken("broken"))
    with pytest.raises(RuntimeError, match="broken"):
        made["run"](root)
    assert all(node.status != Status.RUNNING for node in root.iterate())


def test_children_that_are_activated_again_are_those_of_py_trees_without_synchronising():
    root = {"kind": "parallel", "retick": True, "children": {"a": {"node": "flow/succeed"}}}
    made = export(Task.model_validate({"grip": 1, "name": "t", "root": root}), Catalog.builtin())
    assert "SuccessOnAll(synchronise=False)" in made
    ruled = export(Task.model_validate({"grip": 1, "name": "t", "root": {**root, "policy": "any"}}), Catalog.builtin())
    assert 'Parallel(policy="any", retick=True)' in ruled


def test_flow_nodes_that_set_compute_and_count_need_no_grip() -> None:
    children = {
        "words": {"node": "flow/set", "with": {"value": ["a", "b'\""]}, "out": {"value": "words"}},
        "count": {"node": "flow/count", "with": {"step": 2}, "in": {"count": "n"}, "out": {"count": "m"}},
        "sum": {
            "node": "flow/compute",
            "with": {"expression": "a * 10 + len(b)"},
            "in": {"a": "m", "b": "words"},
            "out": {"value": "sum"},
        },
    }
    types = {"words": "list[str]", "n": {"type": "int", "value": 1}, "m": "int", "sum": "int"}
    text = of({"kind": "sequence", "children": children}, data=types)
    assert "grip_bt" not in text
    made: dict[str, Any] = {}
    exec(compile(text, "flow.py", "exec"), made)
    root = made["create_root"]()
    assert made["run"](root) == "success"
    given = {child.name: child.variable.get() for child in root.children}
    assert given == {"words": ["a", "b'\""], "count": 3, "sum": 32}
    assert "grip_bt" in of({"node": "flow/count", "with": {"limit": 3}}), "a limit is an outcome more"


def test_an_initial_value_of_ours_is_made_of_its_fields() -> None:
    pose = {"position": [0.1, 0.2, 0.3], "quaternion": [0.0, 1.0, 0.0, 0.0]}
    leaf = {"node": "grasp/make", "with": {"approach": 0.1, "lift": 0.15}, "in": {"pose": "p"}, "out": {"grasp": "g"}}
    text = of(leaf, data={"p": {"type": "Pose", "value": pose}, "g": "Grasp"})
    (made,) = (
        node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call) and ast.unparse(node.func) == "Pose"
    )
    assert eval(ast.unparse(made), {"Pose": Pose}) == Pose(**pose)
