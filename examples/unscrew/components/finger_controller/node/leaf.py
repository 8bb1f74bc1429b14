# Generated from component.yaml by `grip component add`; edits here are lost when it runs again.
"""The leaf of the component finger_controller: /finger_controller/control of type finger_interfaces/srv/Control."""

from grip_bt.nodes.component import ComponentLeaf


class FingerController(ComponentLeaf):
    """Sends the inputs as the request and ends with the outcome that the response numbers.

    Inputs and outputs are declared in manifest.yaml; `labels` names the outcome numbers, from 0.
    """

    component = "finger_controller"
    labels = (
        "going",
        "done",
        "out_of_reach",
    )
