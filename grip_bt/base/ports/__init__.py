"""Every Protocol between rooms. Adapters (fake, simulation, ROS 2) implement them; `grip_bt.app` picks the adapters.

Whatever takes time returns an `Operation`. Motions end with what was *measured*, never with what was sent. Expected
trouble ends an operation with an `ExpectedError`, whose code becomes the failure reason of the leaf.
"""

from .context import Context
from .external import Component, Ros
from .hands import Hand, HandPort
from .messages import Messages
from .motion import FREEDOMS, Arm, Executor, Steerable
from .scene import Scene
from .sensing import Camera, Sensor
from .timing import Clock, InTurnOf, Pausable, Stepped

__all__ = [
    "Arm",
    "Camera",
    "Clock",
    "Component",
    "Context",
    "Executor",
    "FREEDOMS",
    "Hand",
    "HandPort",
    "InTurnOf",
    "Messages",
    "Pausable",
    "Ros",
    "Scene",
    "Sensor",
    "Steerable",
    "Stepped",
]
