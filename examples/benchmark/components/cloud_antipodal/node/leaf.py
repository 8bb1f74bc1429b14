# Generated from component.yaml by `grip component add`; edits here are lost when it runs again.
"""The leaf of the component cloud_antipodal: /detect_grasps of type hand_search_interfaces/srv/DetectGrasps."""

from types import MappingProxyType

from grip_bt.nodes.component import ComponentLeaf


class CloudAntipodal(ComponentLeaf):
    """Sends the inputs as the request and ends with the outcome whose rule holds.

    Inputs and outputs are declared in manifest.yaml; the first outcome whose rule holds over the outputs is the node's.
    """

    component = "cloud_antipodal"
    rules = MappingProxyType(
        {
            "found": "len(configs) > 0",
            "none": "true",
        }
    )
