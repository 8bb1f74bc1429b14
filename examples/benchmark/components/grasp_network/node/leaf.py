# Generated from component.yaml by `grip component add`; edits here are lost when it runs again.
"""The leaf of the component grasp_network: /predict_grasps of type grasp_network_interfaces/srv/Predict."""

from types import MappingProxyType

from grip_bt.nodes.component import ComponentLeaf


class GraspNetwork(ComponentLeaf):
    """Sends the inputs as the request and ends with the outcome whose rule holds.

    Inputs and outputs are declared in manifest.yaml; the first outcome whose rule holds over the outputs is the node's.
    """

    component = "grasp_network"
    rules = MappingProxyType(
        {
            "found": "success",
            "none": "true",
        }
    )
