# Generated from component.yaml by `grip component add`; edits here are lost when it runs again.
"""What the node component/plan_grasp does with each answer; the component itself isn't needed."""

from pathlib import Path

import pytest

from grip_bt.codegen.rehearsal import rehearse

HERE = Path(__file__).parent
REPLY = {
    "returned_object": object(),
}
FEEDBACK = object()


@pytest.mark.parametrize(
    ("number", "outcome", "meaning"),
    [
        (0, "found", "success"),
        (1, "none", "failure"),
    ],
)
def test_each_number_has_its_outcome(number, outcome, meaning):
    """The response's number is an index into the declared outcomes."""
    end = rehearse(HERE, {**REPLY, "outcome": number}, feedback=FEEDBACK)
    assert (end.outcome, end.meaning) == (outcome, meaning)
    assert end.outputs == {"feedback": FEEDBACK, **(REPLY if meaning == "success" else {})}


@pytest.mark.parametrize("number", [-1, 2])
def test_an_undeclared_number_is_a_failure(number):
    """A number that isn't declared breaks the contract."""
    end = rehearse(HERE, {**REPLY, "outcome": number})
    assert (end.outcome, end.code) == ("failure", "bad_reply")


def test_the_request_holds_every_bound_input():
    """Each input is a field of the request."""
    inputs = {
        "input": object(),
        "reach": object(),
    }
    assert rehearse(HERE, {**REPLY, "outcome": 0}, inputs).request == inputs
