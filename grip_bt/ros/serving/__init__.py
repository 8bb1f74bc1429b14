"""Parts of ours served to others over ROS 2: executors as trajectory controllers, cameras and joints as topics.

So a simulated robot is reached as a real one is, by any program that speaks ROS.
"""

from .camera import ServedCamera
from .joints import ServedJoints
from .trajectory import ServedController

__all__ = ["ServedCamera", "ServedController", "ServedJoints"]
