"""What a task is: frozen models, the text that they are read from and written to, and edits of both.

`model`, `parts` and `kinds/`, `document` (text -> task, with places), `canonical` and `comments` (task -> text),
`exploration` and `kind_analysis` (what a kind can do), `edit/`, `catalog/`, `validation/`.
"""

from grip_bt.base.frozen import FrozenDict as FrozenDict
from grip_bt.task.document import schema as schema
from grip_bt.task.model import children_of as children_of
from grip_bt.task.model import expressions_of as expressions_of
from grip_bt.task.model import join as join
from grip_bt.task.model import outcomes_of as outcomes_of
from grip_bt.task.model import walk as walk
from grip_bt.task.model import with_refusal as with_refusal

from .canonical import dumps as dumps
from .canonical import fmt as fmt
from .document import Document as Document
from .document import load as load
from .document import loads as loads
from .document import read as read
from .document import read_text as read_text
from .model import KINDS as KINDS
from .model import AnyNode as AnyNode
from .model import Container as Container
from .model import Cooldown as Cooldown
from .model import Fallback as Fallback
from .model import Force as Force
from .model import ForEach as ForEach
from .model import Foreign as Foreign
from .model import Guard as Guard
from .model import Invert as Invert
from .model import Leaf as Leaf
from .model import Loop as Loop
from .model import Meaning as Meaning
from .model import Parallel as Parallel
from .model import Repeat as Repeat
from .model import Retry as Retry
from .model import Sequence as Sequence
from .model import StateMachine as StateMachine
from .model import Subtask as Subtask
from .model import Switch as Switch
from .model import Task as Task
from .model import Timeout as Timeout
from .model import Variable as Variable
