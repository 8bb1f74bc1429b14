"""What each command does to a task, and what it refuses."""

import pytest

from grip_bt.base.errors import EditError
from grip_bt.task import dumps, loads
from grip_bt.task.edit import (
    Add,
    ChangeKind,
    Connect,
    Declare,
    Disconnect,
    Group,
    Move,
    Remove,
    Rename,
    RenameVariable,
    Set,
    SetMeaning,
    Unset,
    Unwrap,
    Wrap,
    apply,
    command_of,
    path_after,
)

HEAD = "grip: 1\nname: a\n"
LEAF = {"node": "a/b"}
SEQUENCE = loads(
    HEAD + "outcomes: {success: success, failure: failure, empty: success}\nroot:\n  kind: sequence\n"
    "  outcomes: {empty: success}\n  exits: {look.none: empty}\n"
    "  on: {success: success, failure: failure, empty: empty}\n  children:\n"
    "    look: {node: a/look, meaning: {none: failure}}\n    take: {node: a/take}\n    put: {node: a/put}\n"
)
MACHINE = loads(
    HEAD + "root:\n  kind: state_machine\n  initial: look\n  outcomes: {success: success, lost: failure}\n"
    "  on: {success: success, lost: failure}\n  children:\n"
    "    look: {node: a/look, on: {success: take, none: lost, failure: look}}\n"
    "    take: {node: a/take, on: {success: put, failure.no_ik: look, failure: lost}}\n"
    "    put: {node: a/put, on: {success: success, failure: take}}\n"
)


def root_after(task, *commands):
    return apply(task, Group(commands=commands)).task.root


def test_a_wrapped_child_keeps_its_exit_through_the_new_container():
    root = root_after(SEQUENCE, Wrap(paths=("look",), kind="retry", name="again", fields={"times": 3}))
    again = root.children["again"]
    assert (again.times, dict(again.outcomes), dict(again.exits)) == (3, {"empty": "failure"}, {"look.none": "empty"})
    assert dict(root.exits) == {"again.empty": "empty"}
    assert list(root.children) == ["again", "take", "put"]


def test_wrapped_neighbours_stay_in_order_and_become_a_machine_where_asked():
    machine = root_after(SEQUENCE, Wrap(paths=("look", "take"), kind="state_machine", name="m")).children["m"]
    assert machine.initial == "look"
    assert dict(machine.children["look"].on) == {"success": "take", "failure": "failure", "none": "empty"}
    assert dict(machine.children["take"].on) == {"success": "success", "failure": "failure"}


def test_states_are_grouped_into_a_machine_that_leads_where_they_led():
    root = root_after(
        MACHINE, Wrap(paths=("take", "put"), kind="state_machine", name="move", fields={"initial": "take"})
    )
    move = root.children["move"]
    assert dict(move.on) == {"look": "look", "lost": "lost", "success": "success"}
    assert dict(move.children["take"].on) == {"success": "put", "failure.no_ik": "look", "failure": "lost"}
    assert root.children["look"].on["success"] == "move"
    assert dumps(apply(apply(MACHINE, Wrap(paths=("take", "put"), kind="state_machine", name="m")).task,
                       Unwrap(path="m")).task) == dumps(MACHINE)  # fmt: skip


def test_a_wrapped_state_gives_its_edges_to_the_container():
    root = root_after(MACHINE, Wrap(paths=("look",), kind="timeout", name="soon", fields={"seconds": 2}))
    soon = root.children["soon"]
    assert root.initial == "soon"
    assert dict(soon.on) == {"success": "take", "none": "lost", "failure": "soon"}
    assert dict(soon.exits) == {"look.none": "none"}
    assert dict(soon.child["look"].on) == {}
    assert root.children["take"].on["failure.no_ik"] == "soon"


def test_a_sequence_becomes_a_machine_with_the_edges_it_implied_and_back():
    machine = root_after(SEQUENCE, ChangeKind(path="/", kind="state_machine"))
    assert machine.initial == "look"
    assert dict(machine.children["look"].on) == {"success": "take", "failure": "failure", "none": "empty"}
    assert dict(machine.children["put"].on) == {"success": "success", "failure": "failure"}
    assert dict(machine.outcomes) == {"empty": "success", "success": "success", "failure": "failure"}
    back = root_after(SEQUENCE, ChangeKind(path="/", kind="state_machine"), ChangeKind(path="/", kind="sequence"))
    assert back == SEQUENCE.root


def test_a_moved_node_leaves_its_edges_behind_and_takes_a_free_name():
    task = apply(MACHINE, Wrap(paths=("put",), kind="sequence", name="last")).task
    done = apply(task, Move(path="look", parent="last", index=0, name="see"))
    assert list(done.task.root.children["last"].children) == ["see", "put"]
    assert done.task.root.initial == "take"
    assert dict(done.task.root.children["take"].on) == {"success": "last", "failure": "lost"}
    assert path_after("look", done.steps) == "last/see"


def test_edges_and_exits_are_connected_and_disconnected():
    root = root_after(
        MACHINE, Connect(path="put", outcome="failure.slipped", target="look"), Disconnect(path="look", outcome="none")
    )
    assert root.children["put"].on["failure.slipped"] == "look"
    assert "none" not in root.children["look"].on
    assert dict(root_after(SEQUENCE, Connect(path="take", outcome="failure", target="empty")).exits) == {
        "look.none": "empty",
        "take.failure": "empty",
    }


def test_meanings_are_set_on_leaves_containers_and_the_task():
    task = apply(SEQUENCE, SetMeaning(path="look", outcome="none", meaning="success")).task
    assert task.root.children["look"].meaning["none"] == "success"
    assert apply(task, SetMeaning(path="look", outcome="none", meaning=None)).task.root.children["look"].meaning == {}
    assert (
        apply(task, SetMeaning(path="/", outcome="empty", meaning="failure")).task.root.outcomes["empty"] == "failure"
    )
    plain = loads(HEAD + "root: {node: a/b}\n")
    assert dict(apply(plain, SetMeaning(path="", outcome="lost", meaning="failure")).task.outcomes) == {
        "success": "success",
        "failure": "failure",
        "lost": "failure",
    }


@pytest.mark.parametrize(
    ("task", "command", "words"),
    [
        (SEQUENCE, Remove(path="looc"), "did you mean 'look'"),
        (SEQUENCE, Remove(path="/"), "the root can't be removed"),
        (SEQUENCE, Add(parent="look", name="x", node={"node": "a/b"}), "a leaf holds no nodes"),
        (SEQUENCE, Add(parent="/", name="look", node={"node": "a/b"}), "the name is taken"),
        (SEQUENCE, Add(parent="/", name="x", node={"kind": "timeout", "child": {"y": LEAF}}), "'seconds' is missing"),
        (SEQUENCE, Add(parent="/", name="x", node={"node": "a/b", "with_": {}}), "no key 'with_'"),
        (SEQUENCE, Rename(path="look", name="take"), "the name is taken"),
        (SEQUENCE, Rename(path="/", name="x"), "has no name"),
        (SEQUENCE, Move(path="look", parent="take"), "a leaf holds no nodes"),
        (SEQUENCE, Set(path="/", key=("children",), value={}), "use `add`"),
        (SEQUENCE, Set(path="/", key=("memry",), value=False), "did you mean 'memory'"),
        (SEQUENCE, Set(path="/", key=("memory",), value="no"), "valid boolean"),
        (SEQUENCE, Connect(path="look", outcome="failure", target="take"), "need a state_machine"),
        (MACHINE, Connect(path="look", outcome="failure", target="tak"), "did you mean 'take'"),
        (MACHINE, Disconnect(path="look", outcome="lost"), "isn't connected"),
        (SEQUENCE, Wrap(paths=("look", "put"), kind="sequence", name="x"), "side by side"),
        (SEQUENCE, Wrap(paths=("look", "take"), kind="retry", name="x"), "has one child"),
        (SEQUENCE, Wrap(paths=("look",), kind="retri", name="x"), "did you mean 'retry'"),
        (MACHINE, Wrap(paths=("look", "take"), kind="sequence", name="x"), "states become a state_machine"),
        (MACHINE, Wrap(paths=("look", "take"), kind="state_machine", name="x"), "one entry"),
        (SEQUENCE, Unwrap(path="look"), "a leaf holds no nodes"),
        (SEQUENCE, Unwrap(path="/"), "a task has one root"),
        (SEQUENCE, ChangeKind(path="look", kind="sequence"), "only a container"),
        (SEQUENCE, ChangeKind(path="/", kind="invert"), "has one child"),
        (SEQUENCE, Unset(path="look", key=("in", "cloud")), "`in` has no 'cloud'"),
        (SEQUENCE, RenameVariable(path="", name="cloud", to="points"), "no variable 'cloud'"),
        (SEQUENCE, Declare(path="look", name="n", variable="int"), "a leaf holds no nodes"),
        (SEQUENCE, SetMeaning(path="/", outcome="empty", meaning=None), "needs a meaning"),
    ],
)  # fmt: skip
def test_what_cant_be_done_is_refused_and_says_why(task, command, words):
    before = dumps(task)
    with pytest.raises(EditError) as caught:
        apply(task, command)
    assert words in str(caught.value)
    assert dumps(task) == before


def test_a_group_is_all_or_nothing():
    before = dumps(SEQUENCE)
    with pytest.raises(EditError):
        apply(SEQUENCE, Group(commands=(Remove(path="look"), Remove(path="look"))))
    assert dumps(SEQUENCE) == before


def test_commands_come_from_data_as_they_go_over_a_wire():
    data = {"do": "group", "commands": [{"do": "move", "path": "look", "parent": "/", "index": 2}]}
    command = command_of(data)
    assert list(apply(SEQUENCE, command).task.root.children) == ["take", "put", "look"]
    assert command_of(command.model_dump(mode="json")) == command
