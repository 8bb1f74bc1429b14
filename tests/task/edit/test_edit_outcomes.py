"""A renamed outcome: everything that speaks of it follows, in the text too, and what can't is refused."""

import pytest

from grip_bt.base.errors import EditError
from grip_bt.task import loads, read_text
from grip_bt.task.edit import RenameOutcome, apply, apply_to_document

TEXT = """\
grip: 1
name: a
outcomes: {done: success, lost: failure}
root:
  kind: state_machine
  initial: look
  outcomes: {done: success, lost: failure, failure: failure}
  on: {done: done, lost.no_ik: lost, lost: lost, failure: lost}
  children:
    look:
      kind: parallel
      outcomes: {seen: success}
      rules:
        # both of them
        - {when: {left: success, right: [none, none.dark]}, then: seen}
      children:
        left: {node: a/look}
        right:
          kind: retry
          times: 2
          outcomes: {none: failure}  # nothing is there
          exits: {again.none: none}
          child:
            again: {node: a/look, meaning: {none: failure}}
      # where it goes
      on: {seen: done, success: done, failure: lost}
"""


def renamed(path, outcome, to):
    document = read_text(TEXT)
    done = apply_to_document(document, RenameOutcome(path=path, outcome=outcome, to=to))
    old, new = TEXT.split("\n"), done.document.text.split("\n")
    assert len(old) == len(new)
    return [after.strip() for before, after in zip(old, new, strict=True) if before != after]


def test_an_outcome_of_the_task_is_renamed_with_the_edges_of_the_root():
    assert renamed("", "lost", "gone") == [
        "outcomes: {done: success, gone: failure}",
        "on: {done: done, lost.no_ik: gone, lost: gone, failure: gone}",
    ]


def test_an_outcome_of_a_machine_is_renamed_with_its_codes_and_the_edges_inside():
    assert renamed("/", "lost", "gone") == [
        "outcomes: {done: success, gone: failure, failure: failure}",
        "on: {done: done, gone.no_ik: lost, gone: lost, failure: lost}",
        "on: {seen: done, success: done, failure: gone}",
    ]


def test_an_outcome_within_a_parallel_is_renamed_in_exits_and_rules():
    assert renamed("look", "seen", "found") == [
        "outcomes: {found: success}",
        "- {when: {left: success, right: [none, none.dark]}, then: found}",
        "on: {found: done, success: done, failure: lost}",
    ]
    assert renamed("look/right", "none", "empty") == [
        "- {when: {left: success, right: [empty, empty.dark]}, then: seen}",
        "outcomes: {empty: failure}  # nothing is there",
        "exits: {again.none: empty}",
    ]


def test_a_root_that_ended_by_the_word_gets_an_edge():
    task = loads("grip: 1\nname: a\nroot: {kind: sequence, children: {b: {node: a/b}}}\n")
    done = apply(task, RenameOutcome(path="", outcome="failure", to="gave_up")).task
    assert dict(done.outcomes) == {"success": "success", "gave_up": "failure"}
    assert dict(done.root.on) == {"failure": "gave_up"}


@pytest.mark.parametrize(
    ("path", "outcome", "to", "words"),
    [
        ("look", "success", "ok", "a parallel keeps its 'success'"),
        ("look", "sene", "ok", "did you mean 'seen'"),
        ("look", "seen", "success", "there is an outcome 'success' already"),
        ("/", "lost", "look", "would mean the child of that name"),
        ("look/left", "success", "ok", "the outcomes of a leaf aren't its task's to rename"),
        ("look/leftt", "success", "ok", "did you mean 'look/left'"),
    ],
)
def test_what_cant_be_renamed_is_refused(path, outcome, to, words):
    with pytest.raises(EditError, match=words):
        apply(loads(TEXT), RenameOutcome(path=path, outcome=outcome, to=to))


def test_an_outcome_that_is_known_only_elsewhere_is_refused():
    leaf = loads("grip: 1\nname: a\noutcomes: {none: success, success: success, failure: failure}\nroot: {node: a/b}\n")
    with pytest.raises(EditError, match="whether a/b ends with 'none' isn't known here"):
        apply(leaf, RenameOutcome(path="", outcome="none", to="x"))
    machine = loads(TEXT.replace("kind: state_machine", "kind: state_machine\n  precondition: 'true'"))
    with pytest.raises(EditError, match="its precondition ends it with 'failure' too"):
        apply(machine, RenameOutcome(path="/", outcome="failure", to="x"))
