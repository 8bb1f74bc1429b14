"""Leaves and control nodes: py_trees behaviours that know only ports, messages and values.

* `node` (path, labelled end, reason), `leaf`, `async_leaf`, `function` (`@leaf`): what leaves are made of.
* `container` with `answers`: a container whose kind (`grip_bt.task.kinds`) says what follows; `control/`: the others.
* Leaves by subject: `arm*`, `hand`, `grasping`, `place`, `perception`, `scene*`, `flow`, `messages`, `ros`,
  `component`.
* Geometry without a robot: `objects`, `camera_views`. `evidence`: is something held.
* `mock` stands in for a leaf; `smach_*`: states of legacy machines as leaves.
"""

from .leaf import Leaf as Leaf
from .leaf import OperationLeaf as OperationLeaf
