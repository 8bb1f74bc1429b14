"""Every Protocol between rooms. Adapters (fake, simulation, ROS 2) implement them; `grip_bt.app` picks the adapters.

Whatever takes time returns an `Operation`. Motions end with what was *measured*, never with what was sent. Expected
trouble ends an operation with an `ExpectedError`, whose code becomes the failure reason of the leaf.
"""

from .context import Clock, Context, InTurnOf, Pausable, Stepped
from .hands import Hand, HandPort
from .motion import FREEDOMS, Arm, Executor, Steerable
from .world import Camera, Component, Messages, Ros, Scene, Sensor

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
