"""A copy comes under a fresh name, with the variables that it needs, in the same task and in another one."""

import json

import pytest

from grip_bt.base.errors import EditError
from grip_bt.task import dumps, loads, read_text
from grip_bt.task.edit import Paste, apply, apply_to_document, clip_of, command_of

TEXT = """\
grip: 1
name: a
data:
  cloud: PointCloud  # from above
  count: {type: int, value: 3}
root:
  kind: sequence
  children:
    look: {node: a/look, out: {cloud: cloud}}
    # the one that is copied
    take:
      kind: for_each
      items: grasps
      item: grasp
      precondition: count > 0
      data: {own: int}
      child:
        move: {node: a/move, in: {grasp: grasp, cloud: cloud}, out: {n: own}}
    machine:
      kind: state_machine
      initial: one
      outcomes: {success: success, failure: failure}
      children:
        one: {node: a/one, on: {success: two, failure: failure}}
        two: {node: a/two, on: {success: success, failure: one}}
"""
OTHER = """\
grip: 1
name: b
data: {count: str}
root:
  kind: sequence
  children:
    home: {node: a/home}
"""


def test_a_clip_holds_the_node_and_the_variables_that_are_declared_around_it():
    clip = clip_of(loads(TEXT), "take")
    assert clip.name == "take"
    assert dict(clip.variables) == {"cloud": "PointCloud", "count": {"type": "int", "value": 3}}
    assert clip.node["child"]["move"]["node"] == "a/move"
    wire = json.loads(Paste(parent="/", clip=clip).model_dump_json())
    assert command_of(wire) == Paste(parent="/", clip=clip)


def test_a_copy_beside_its_origin_has_another_name_and_shares_the_variables():
    document = read_text(TEXT)
    done = apply_to_document(document, Paste(parent="/", clip=clip_of(document.task, "take"), index=2))
    children = done.document.task.root.children
    assert list(children) == ["look", "take", "take_2", "machine"]
    assert children["take_2"] == children["take"]
    assert done.document.task.data == document.task.data
    assert "    # the one that is copied\n    take:" in done.document.text
    again = apply(done.document.task, Paste(parent="/", clip=clip_of(done.document.task, "take_2"))).task
    assert list(again.root.children)[-1] == "take_3"


def test_a_copy_may_have_variables_of_its_own():
    task = loads(TEXT)
    done = apply(task, Paste(parent="/", clip=clip_of(task, "take"), variables="fresh")).task
    copy = done.root.children["take_2"]
    assert dict(copy.child["move"].in_) == {"grasp": "grasp", "cloud": "cloud_2"}
    assert copy.precondition == "count_2 > 0"
    assert {k: getattr(v, "value", v) for k, v in done.root.data.items()} == {"cloud_2": "PointCloud", "count_2": 3}


def test_in_another_task_missing_variables_come_along_and_other_types_get_other_names():
    done = apply(loads(OTHER), Paste(parent="/", clip=clip_of(loads(TEXT), "take"))).task
    copy = done.root.children["take"]
    assert (copy.precondition, dict(copy.child["move"].in_)) == ("count_2 > 0", {"grasp": "grasp", "cloud": "cloud"})
    assert list(done.root.data) == ["cloud", "count_2"]
    assert loads(dumps(done)) == done


def test_edges_that_lead_somewhere_there_stay_and_the_others_go():
    task = loads(TEXT)
    within = apply(task, Paste(parent="machine", clip=clip_of(task, "machine/one"))).task
    assert dict(within.root.children["machine"].children["one_2"].on) == {"success": "two", "failure": "failure"}
    outside = apply(task, Paste(parent="/", clip=clip_of(task, "machine/one"), name="alone")).task
    assert dict(outside.root.children["alone"].on) == {}


@pytest.mark.parametrize(
    ("parent", "clip", "name", "words"),
    [
        ("/", {"name": "x", "node": {"node": "a/b"}}, "look", "the name is taken"),
        ("take", {"name": "x", "node": {"node": "a/b"}}, None, "a for_each has one child"),
        ("look", {"name": "x", "node": {"node": "a/b"}}, None, "a leaf holds no nodes"),
        ("/", {"name": "x", "node": {"kind": "retri"}}, None, "x: .*retri"),
    ],
)
def test_what_cant_be_pasted_is_refused(parent, clip, name, words):
    with pytest.raises(EditError, match=words):
        apply(loads(TEXT), command_of({"do": "paste", "parent": parent, "clip": clip, "name": name}))
