"""Edits of texts: what they change, what they leave alone, and that they can be undone to the byte."""

import pytest
from hypothesis import HealthCheck, event, given, settings
from hypothesis import strategies as st
from random_commands import commands
from random_tasks import tasks
from random_texts import with_comments

from grip_bt.base.errors import EditError
from grip_bt.task import Leaf, dumps, fmt, loads, read_text, walk
from grip_bt.task.edit import apply, apply_to_document, command_of
from grip_bt.task.edit.text_places import line_start, one_entry_a_line, region_end

unhurried = settings(
    deadline=None, max_examples=50, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
randoms = st.randoms(use_true_random=False)
KEEPING = ("add", "rename", "connect", "declare", "rename_variable")
LOCAL = ("set", "unset", "add", "set_meaning", "declare", "undeclare", "comment")


def edited(data, task, random, kinds=None):
    """Return a commented document of a task, its comments, a command, and the edited document; None when refused."""
    text, comments = with_comments(dumps(task), random)
    document = read_text(text)
    command = data.draw(commands(document.task, kinds) if kinds else commands(document.task))
    try:
        done = apply(document.task, command)
    except EditError:
        return None
    event(command.do)
    after = apply_to_document(document, command)
    assert dumps(after.document.task) == dumps(done.task)
    return document, comments, command, after


@unhurried
@given(st.data(), tasks, randoms)
def test_edits_that_take_nothing_out_keep_every_comment(data, task, random):
    made = edited(data, task, random, KEEPING)
    if made is None:
        return
    _, comments, _, after = made
    for comment in comments:
        assert comment in after.document.text


@unhurried
@given(st.data(), tasks, randoms)
def test_the_lines_of_other_nodes_stay_as_they_are(data, task, random):
    made = edited(data, task, random, LOCAL)
    if made is None:
        return
    document, _, command, after = made
    about = getattr(command, "path", None) or getattr(command, "parent", "")
    for path, node in walk(document.task.root):
        if path != about and (isinstance(node, Leaf) or not _above(path, about)):
            before = lines_of_node(document, path)
            assert before is None or lines_of_node(after.document, path) == before


def _above(path, other):
    return path == "/" or other.startswith(f"{path}/")


def lines_of_node(document, path):
    """Return a node's lines; None where it stands in braces."""
    entry, inside = document._entry(path), document.tree
    if path != "/":
        above = document._entry(path.rpartition("/")[0] or "/").value
        inside = next(above.entries[key].value for key in ("children", "child") if key in above.entries)
    if not one_entry_a_line(document.text, inside):
        return None
    return document.text[line_start(document.text, entry.start) : region_end(document.text, entry)]


def edit(text, **command):
    """Return a text after a command."""
    return apply_to_document(read_text(text), command_of(command)).document.text


TEXT = """\
# A task.
grip: 1
name: demo   # its name
data: {cloud: PointCloud, grasp: Grasp}

root:
    kind: state_machine
    initial: look
    outcomes: {done: success, lost: failure}
    on: {done: success, lost: failure}   # the ends
    children:
        # first we look
        look:
            node: "sensor/overhead"
            out: {points: cloud}         # fill it
            on: {success: take, failure: lost}

        # then we take
        take: {node: arm/take, with: {speed: 0.5}, in: {cloud: cloud}, on: {success: done, failure.no_ik: look, failure: lost}}
            # closes take
        rest:   # last
            node: flow/wait
            doc: |
                # no comment

                really
            on: {success: done}
        # closes the children
"""  # noqa: E501


def changed_lines(before, after):
    """Return the lines that went and those that came."""
    import difflib

    lines = list(difflib.ndiff(before.split("\n"), after.split("\n")))
    return [li[2:] for li in lines if li.startswith("- ")], [li[2:] for li in lines if li.startswith("+ ")]


def test_a_rename_changes_the_key_and_the_references_and_nothing_else():
    gone, came = changed_lines(TEXT, edit(TEXT, do="rename", path="look", name="see"))
    assert [line.strip()[:14] for line in gone] == ["initial: look", "look:", "take: {node: a"]
    assert came == [line.replace("look", "see") for line in gone]


def test_a_variable_is_renamed_where_it_is_declared_and_bound():
    gone, came = changed_lines(TEXT, edit(TEXT, do="rename_variable", path="", name="cloud", to="points"))
    assert len(gone) == len(came) == 3
    assert "            out: {points: points}         # fill it" in came


def test_a_removed_node_takes_its_comments_and_the_edges_to_it_along():
    after = edit(TEXT, do="remove", path="take")
    assert "then we take" not in after
    assert "closes take" not in after
    assert "            on: {failure: lost}\n        rest:   # last\n" in after
    assert after.endswith("        # closes the children\n")


def test_a_moved_node_takes_its_comments_along():
    after = edit(TEXT, do="move", path="look", parent="/", index=2)
    assert after.index("rest:") < after.index("# first we look") < after.index("# closes the children")
    assert sorted(after.split("\n")) == sorted(TEXT.split("\n"))


def test_a_node_that_moves_deeper_is_indented_and_keeps_its_block_of_text():
    after = edit(TEXT, do="wrap", paths=["rest"], kind="retry", name="again", fields={"times": 2})
    assert loads(after).root.children["again"].child["rest"].doc == "# no comment\n\nreally\n"
    assert "            rest:   # last\n                node: flow/wait\n" in after


def test_a_key_of_a_node_in_braces_is_set_within_its_line():
    after = edit(TEXT, do="set", path="take", key=["with", "speed"], value=0.25)
    gone, came = changed_lines(TEXT, after)
    assert came == [gone[0].replace("0.5", "0.25")]
    assert len(gone) == 1


def test_a_node_in_braces_that_grows_too_long_is_spread_out_alone():
    after = edit(TEXT, do="set", path="take", key=["out", "held"], value="grasp")
    gone, _ = changed_lines(TEXT, after)
    assert len(gone) == 1
    assert "        take:\n          node: arm/take\n" in after
    assert "\n            # closes take\n" in after


def test_a_variable_is_declared_in_braces_where_there_is_room():
    after = edit(TEXT, do="declare", path="", name="n", variable={"type": "int", "value": 3}, index=1)
    assert "data: {cloud: PointCloud, n: {type: int, value: 3}, grasp: Grasp}\n" in after
    long = edit(TEXT, do="declare", path="", name="n", variable={"type": "int", "doc": "x" * 60})
    assert "data:\n  cloud: PointCloud\n  grasp: Grasp\n  n: {type: int, doc: xxx" in long


def test_a_new_key_takes_its_canonical_place():
    after = edit(TEXT, do="set", path="look", key=["doc"], value="Look at the table.")
    assert '            node: "sensor/overhead"\n            doc: Look at the table.\n            out:' in after


def test_the_last_entry_leaves_an_empty_mapping_or_no_key():
    after = edit(TEXT, do="unset", path="look", key=["out", "points"])
    assert '            node: "sensor/overhead"\n            on: {success: take' in after
    text = "grip: 1\nname: a\nroot:  # here\n  kind: sequence\n  children:  # two\n    a: {node: b/c}\n"
    empty = edit(text, do="remove", path="a")
    assert empty == "grip: 1\nname: a\nroot:  # here\n  kind: sequence\n  children: {}  # two\n"
    assert edit(empty, do="add", parent="/", name="b", node={"node": "c/d"}).endswith(
        "  children:  # two\n    b: {node: c/d}\n"
    )


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize(
    "text",
    [
        "{grip: 1, # one\n name: a, # two\n root: {kind: sequence, children: {a: {node: b/c}, d: {node: e/f}}}}\n",
        "grip: 1\nname: a\nroot: {kind: sequence, children: {a: {node: b/c}, d: {node: e/f}}}",
        "---\ngrip: 1\nname: a\nroot:\n  kind: sequence\n  children:\n    'a': {node: b/c}\n    d:\n\n"
        "      node: e/f\n\n\n# end\n...\n",
        "grip: 1\nname: a\nroot:\n    kind: sequence\n    children: # of mine\n\n\n      a:\n        {node: b/c}\n"
        "      d: { node : e/f , doc: 'it''s'}  # d",
    ],
)
def test_odd_but_common_spellings_are_edited_in_place(text, newline):
    text = text.replace("\n", newline)
    for command in (
        {"do": "rename", "path": "a", "name": "b c"},
        {"do": "remove", "path": "a"},
        {"do": "remove", "path": "d"},
        {"do": "move", "path": "a", "parent": "/"},
        {"do": "set", "path": "d", "key": ["doc"], "value": "two\nlines\n"},
        {"do": "wrap", "paths": ["a", "d"], "kind": "fallback", "name": "one"},
        {"do": "wrap", "paths": ["/"], "kind": "invert", "name": "not"},
        {"do": "set", "path": "a", "key": ["in", "p"], "value": "v"},
        {"do": "change_kind", "path": "/", "kind": "state_machine"},
        {"do": "add", "parent": "/", "name": "n", "index": 1, "node": {"kind": "sequence", "children": {}}},
    ):
        after = edit(text, **command)
        assert loads(after) == apply(loads(text), command_of(command)).task
        for word in ("# one", "# two", "# of mine", "# end", "# d"):
            if command["do"] != "remove":
                assert (word in after) == (word in text), (command, word)
        if newline == "\r\n":
            assert "\n" not in after.replace("\r\n", "")


def test_a_spelling_that_cant_be_edited_is_refused_with_the_way_out():
    text = "grip: 1\nname: a\nroot:\n  ? kind\n  : sequence\n  ? children\n  : a: {node: b/c}\n"
    with pytest.raises(EditError, match="grip fmt"):
        edit(text, do="set", path="/", key=["doc"], value="x")
    assert loads(edit(fmt(text), do="set", path="/", key=["doc"], value="x")).root.doc == "x"


PARALLEL = """\
grip: 1
name: a
root:
  kind: parallel
  outcomes: {early: success}
  rules:
    # whoever comes first
    - when: {a: success, b: failure}  # two
      then: early
    - {when: {c: success}, then: early}
  wait_for: [a, b]  # not c
  children:
    a: {node: b/c}
    b: {node: b/c}
    c: {node: b/c}
"""
SWITCH = """\
grip: 1
name: a
data: {all: "list[Pose]", n: int}
root:
  kind: switch
  on_value: n + 1  # counted
  cases: {a: 1, b: [2, 3]}
  default: a
  children:
    a: {kind: for_each, items: all, item: one, child: {go: {node: b/c, in: {to: one}}}}
    b: {kind: guard, if: "n < 3", child: {go: {node: b/c}}}
"""


def test_names_in_rules_cases_and_lists_follow_and_leave_with_their_node():
    gone, came = changed_lines(PARALLEL, edit(PARALLEL, do="rename", path="a", name="x"))
    assert [line.strip() for line in came] == [
        "- when: {x: success, b: failure}  # two",
        "wait_for: [x, b]  # not c",
        "x: {node: b/c}",
    ]
    assert len(gone) == 3
    after = loads(edit(PARALLEL, do="remove", path="a")).root
    assert [dict(rule.when) for rule in after.rules] == [{"c": "success"}]
    assert after.wait_for == ["b"]
    assert edit(SWITCH, do="rename", path="a", name="x").count("x:") == 2
    without = loads(edit(SWITCH, do="remove", path="a")).root
    assert dict(without.cases) == {"b": [2, 3]}
    assert without.default == ""


def test_variables_follow_in_expressions_and_in_what_a_loop_goes_over():
    gone, came = changed_lines(SWITCH, edit(SWITCH, do="rename_variable", path="", name="n", to="count"))
    assert [line.strip() for line in came] == [
        'data: {all: "list[Pose]", count: int}',
        "on_value: count + 1  # counted",
        'b: {kind: guard, if: count < 3, child: {go: {node: b/c}}}',
    ]  # fmt: skip
    assert "items: every" in edit(SWITCH, do="rename_variable", path="", name="all", to="every")
    each = edit(SWITCH, do="rename_variable", path="a", name="one", to="pose")
    assert "item: pose, child: {go: {node: b/c, in: {to: pose}}}" in each
    with pytest.raises(EditError, match="would hide"):
        edit(SWITCH, do="rename_variable", path="", name="all", to="one")
    with pytest.raises(EditError, match="is used by /, b"):
        edit(SWITCH, do="undeclare", path="", name="n")
