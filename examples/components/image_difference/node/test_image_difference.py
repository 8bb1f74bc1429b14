# Generated from component.yaml by `grip component add`; edits here are lost when it runs again.
"""What the node component/image_difference does with each answer; the component itself isn't needed."""

from pathlib import Path

from grip_bt.codegen.rehearsal import rehearse

HERE = Path(__file__).parent
REPLY = {
    "vacated": 0,
    "appeared": 0,
    "shown": 0,
}


def test_every_rule_reads_outputs_only():
    """A rule is an expression over the outputs; this one is read when the node is prepared."""
    assert set(REPLY).issuperset(["appeared", "shown", "vacated"])


def test_an_empty_answer_ends_as_the_rules_say():
    """The first rule that holds names the outcome."""
    end = rehearse(HERE, REPLY)
    assert (end.outcome, end.meaning) == ("untouched", "failure")


def test_the_request_holds_every_bound_input():
    """Each input is a field of the request."""
    inputs = {
        "before": object(),
        "after": object(),
        "hand_before": object(),
        "hand_after": object(),
    }
    assert rehearse(HERE, REPLY, inputs).request == inputs
