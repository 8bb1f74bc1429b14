# Generated from component.yaml by `grip component add`; edits here are lost when it runs again.
"""The leaf of the component registration: /register_clouds of type registration_interfaces/srv/RegisterClouds."""

from grip_bt.nodes.component import ComponentLeaf


class Registration(ComponentLeaf):
    """Sends the inputs as the request and ends with the outcome that the response numbers.

    Inputs and outputs are declared in manifest.yaml; `labels` names the outcome numbers, from 0.
    """

    component = "registration"
    labels = (
        "registered",
        "poor",
    )
