# Generated from component.yaml by `grip component add`; edits here are lost when it runs again.
"""The leaf of the component image_difference: /compare_frames of type grasp_check_interfaces/srv/CompareFrames."""

from types import MappingProxyType

from grip_bt.nodes.component import ComponentLeaf


class ImageDifference(ComponentLeaf):
    """Sends the inputs as the request and ends with the outcome whose rule holds.

    Inputs and outputs are declared in manifest.yaml; the first outcome whose rule holds over the outputs is the node's.
    """

    component = "image_difference"
    rules = MappingProxyType(
        {
            "taken": "vacated >= 60 and appeared <= 0.3 * vacated and shown >= 150",
            "moved": "vacated >= 60 and appeared > 0.3 * vacated",
            "lost": "vacated >= 60",
            "untouched": "vacated < 60",
        }
    )
