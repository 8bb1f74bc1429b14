# Generated from component.yaml by `grip component add`; edits here are lost when it runs again.
"""What the node component/cloud_antipodal does with each answer; the component itself isn't needed."""

from pathlib import Path

from grip_bt.codegen.rehearsal import rehearse

HERE = Path(__file__).parent
REPLY = {
    "configs": object(),
}


def test_every_rule_reads_outputs_only():
    """A rule is an expression over the outputs; this one is read when the node is prepared."""
    assert set(REPLY).issuperset(["configs"])


def test_the_request_holds_every_bound_input():
    """Each input is a field of the request."""
    inputs = {
        "cloud": object(),
    }
    assert rehearse(HERE, REPLY, inputs).request == inputs
