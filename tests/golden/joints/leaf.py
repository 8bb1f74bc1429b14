# Generated from component.yaml by `grip component add`; edits here are lost when it runs again.
"""The leaf of the component joints: /do of type sensor_msgs/msg/JointState."""

from types import MappingProxyType

from grip_bt.nodes.component import ComponentLeaf


class Joints(ComponentLeaf):
    """Waits for the next message.

    Inputs and outputs are declared in manifest.yaml; the first outcome whose rule holds over the outputs is the node's.
    """

    component = "joints"
    rules = MappingProxyType(
        {
            "still": "len(name) == 0",
            "moving": "true",
        }
    )
