"""A conversion as an edit gives the task that a conversion gives, keeps comments, and is undone to the byte."""

from __future__ import annotations

from typing import Any

import pytest
from parity_flows import make_flow
from parity_generate import make_case
from parity_world import catalog_of
from restructure_tasks import CATALOG

from grip_bt.base.errors import EditError, InvalidTaskError
from grip_bt.compilers.restructure import expanded, to_state_machines, to_trees
from grip_bt.task import Task, dumps, loads, read_text, walk
from grip_bt.task.catalog.manifest import Manifest
from grip_bt.task.edit import ChangeKind, Convert, Group, Rename, apply, apply_to_document, command_of, path_after

TEXT = """\
grip: 1
name: a
root:
  kind: sequence
  children:
    # first of all
    ready: {node: test/act}
    pick:
      kind: state_machine
      initial: look
      outcomes: {success: success, failure: failure}
      children:
        # where is it?
        look: {node: test/act, on: {success: take, failure: look}}  # as long as it takes
        take: {node: test/act, on: {success: success, failure: failure}}
    put:
      kind: fallback
      children:
        # gently
        down: {node: test/act}
        drop: {node: test/act}
"""


@pytest.mark.parametrize("make", [make_case, make_flow])
@pytest.mark.parametrize(("to", "convert"), [("bt", to_trees), ("sm", to_state_machines)])
def test_the_edit_gives_the_task_that_the_conversion_gives(make: Any, to: Any, convert: Any) -> None:
    changed = 0
    for seed in range(15):
        case = make(seed)
        task, catalog = Task.model_validate(case["task"]), catalog_of(case)
        wanted = convert(task, catalog).task
        if wanted == task:
            continue
        document = read_text(dumps(task))
        done = apply_to_document(document, expanded(Convert(path="/", to=to), document.task, catalog))
        assert dumps(done.document.task) == dumps(wanted), f"seed {seed}"
        changed += 1
    assert changed > 2


def test_a_change_of_kind_gives_leaves_edges_for_their_own_outcomes_only() -> None:
    catalog = CATALOG.with_manifests(
        [Manifest(id="test/sure", doc="", implementation="x:Y", outcomes={"success": "success"})]
    )
    task = loads(TEXT.replace("ready: {node: test/act}", "ready: {node: test/sure}"))
    root = apply(task, expanded(ChangeKind(path="/", kind="state_machine"), task, catalog)).task.root
    assert dict(root.children["ready"].on) == {"success": "pick"}
    assert dict(root.children["pick"].on) == {"success": "put", "failure": "failure"}


def test_only_what_was_asked_for_is_converted_and_comments_stay() -> None:
    document = read_text(TEXT)
    done = apply_to_document(document, expanded(Convert(path="pick", to="bt"), document.task, CATALOG))
    root = done.document.task.root
    assert [(path, getattr(node, "kind", "")) for path, node in walk(root)] == [
        ("/", "sequence"),
        ("ready", ""),
        ("pick", "sequence"),
        ("pick/repeat_look", "repeat"),
        ("pick/repeat_look/try_look", "sequence"),
        ("pick/repeat_look/try_look/look", ""),
        ("pick/take", ""),
        ("put", "fallback"),
        ("put/down", ""),
        ("put/drop", ""),
    ]
    assert path_after("pick/look", done.steps) == "pick/repeat_look/try_look/look"
    for comment in ("# first of all", "# where is it?", "# as long as it takes", "# gently"):
        assert comment in done.document.text


def test_a_group_may_hold_conversions() -> None:
    task = loads(TEXT)
    group = Group(commands=(Rename(path="put", name="place"), Convert(path="place", to="sm")))
    made = apply(task, expanded(group, task, CATALOG))
    assert made.task.root.children["place"].kind == "state_machine"
    assert command_of(group.model_dump(mode="json")) == group


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (Convert(path="nowhere", to="sm"), "no such node"),
        (Convert(path="pick", to="sm"), "it has that form already"),
        (Convert(path="ready", to="bt"), "it has that form already"),
    ],
)
def test_what_stays_as_it_is_is_refused(command: Convert, words: str) -> None:
    with pytest.raises(EditError, match=words):
        expanded(command, loads(TEXT), CATALOG)


def test_a_reason_is_given_where_a_part_has_no_equal_or_the_task_is_wrong() -> None:
    reactive = loads(TEXT.replace("kind: fallback", "kind: fallback\n      memory: false"))
    with pytest.raises(EditError, match="put: .*it is reactive"):
        expanded(Convert(path="put", to="sm"), reactive, CATALOG)
    wrong = loads(TEXT.replace("test/act}\n    pick", "test/nothing}\n    pick"))
    with pytest.raises(EditError, match="only a task without errors is converted"):
        expanded(Convert(path="put", to="sm"), wrong, CATALOG)
    with pytest.raises(InvalidTaskError):
        to_trees(wrong, CATALOG)


def test_without_a_catalogue_a_conversion_is_refused() -> None:
    with pytest.raises(EditError, match="needs a catalogue"):
        apply(loads(TEXT), Convert(path="put", to="sm"))
