# Generated from component.yaml by `grip component add`; edits here are lost when it runs again.
"""The leaf of the component pca_top: /plan_top_grasps of type pca_interfaces/srv/PlanTopGrasps."""

from types import MappingProxyType

from grip_bt.nodes.component import ComponentLeaf


class PcaTop(ComponentLeaf):
    """Sends the inputs as the request and ends with the outcome whose rule holds.

    Inputs and outputs are declared in manifest.yaml; the first outcome whose rule holds over the outputs is the node's.
    """

    component = "pca_top"
    rules = MappingProxyType(
        {
            "found": "len(grasps) > 0",
            "none": "true",
        }
    )
