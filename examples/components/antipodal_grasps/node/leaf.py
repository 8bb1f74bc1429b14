# Generated from component.yaml by `grip component add`; edits here are lost when it runs again.
"""The leaf of the component antipodal_grasps: /propose_grasps of type antipodal_interfaces/srv/ProposeGrasps."""

from grip_bt.nodes.component import ComponentLeaf


class AntipodalGrasps(ComponentLeaf):
    """Sends the inputs as the request and ends with the outcome that the response numbers.

    Inputs and outputs are declared in manifest.yaml; `labels` names the outcome numbers, from 0.
    """

    component = "antipodal_grasps"
    labels = (
        "one",
        "several",
        "none",
    )
