"""What nodes exist: their manifests, the types of their ports, and the way to their code."""

from grip_bt.base.types import Type as Type
from grip_bt.base.types import check_value as check_value
from grip_bt.base.types import is_assignable as is_assignable
from grip_bt.base.types import parse_type as parse_type

from .catalog import Catalog as Catalog
from .catalog import load_implementation as load_implementation
from .manifest import InputPort as InputPort
from .manifest import Manifest as Manifest
from .manifest import OutputPort as OutputPort
from .manifest import find_manifests as find_manifests
from .manifest import read_manifests as read_manifests
from .python_nodes import find_python_nodes as find_python_nodes
from .python_nodes import read_python_nodes as read_python_nodes
from .source_code import AllowedImports as AllowedImports
from .source_code import CodePath as CodePath
from .task_files import TaskFolder as TaskFolder
from .task_files import TaskTexts as TaskTexts
from .task_files import manifest_of_task as manifest_of_task
