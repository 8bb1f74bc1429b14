# Generated from component.yaml by `grip component add`; edits here are lost when it runs again.
"""The leaf of the component count_objects: /do of type my_pkg/srv/CountObjects."""

from types import MappingProxyType

from grip_bt.nodes.component import ComponentLeaf


class CountObjects(ComponentLeaf):
    """Sends the inputs as the request and ends with the outcome whose rule holds.

    Inputs and outputs are declared in manifest.yaml; the first outcome whose rule holds over the outputs is the node's.
    """

    component = "count_objects"
    rules = MappingProxyType(
        {
            "found": 'count > 0 and note != "a | b"',
            "none": "count == 0",
        }
    )
