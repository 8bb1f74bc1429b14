"""Every Protocol between rooms. Adapters (fake, simulation, ROS 2) implement them; `grip_bt.app` picks the adapters.

Whatever takes time returns an `Operation`. Motions end with what was *measured*, never with what was sent. Expected
trouble ends an operation with an `ExpectedError`, whose code becomes the failure reason of the leaf.
"""

from .context import Clock as Clock
from .context import Context as Context
from .context import InTurnOf as InTurnOf
from .context import Pausable as Pausable
from .context import Stepped as Stepped
from .hands import Hand as Hand
from .hands import HandPort as HandPort
from .hands import Touch as Touch
from .hands import TouchPoints as TouchPoints
from .motion import FREEDOMS as FREEDOMS
from .motion import Arm as Arm
from .motion import Executor as Executor
from .motion import Steerable as Steerable
from .motion import Ways as Ways
from .world import Camera as Camera
from .world import Component as Component
from .world import Messages as Messages
from .world import Ros as Ros
from .world import Scene as Scene
from .world import Sensor as Sensor
