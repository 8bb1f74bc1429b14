# Generated from component.yaml by `grip component add`; edits here are lost when it runs again.
"""The leaf of the component image_antipodal: /find_rectangles of type rectangle_interfaces/srv/FindRectangles."""

from types import MappingProxyType

from grip_bt.nodes.component import ComponentLeaf


class ImageAntipodal(ComponentLeaf):
    """Sends the inputs as the request and ends with the outcome whose rule holds.

    Inputs and outputs are declared in manifest.yaml; the first outcome whose rule holds over the outputs is the node's.
    """

    component = "image_antipodal"
    rules = MappingProxyType(
        {
            "found": "len(rectangles) > 0",
            "none": "true",
        }
    )
