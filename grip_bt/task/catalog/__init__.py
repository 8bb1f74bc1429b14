"""What nodes exist: their manifests, the types of their ports, and the way to their code."""

from grip_bt.base.types import Type, check_value, is_assignable, parse_type

from .catalog import Catalog
from .implementation import load_implementation
from .manifest import InputPort, Manifest, NodeId, OutputPort, Parameter
from .own_code import CodePath, OwnCode
from .python_nodes import find_python_nodes, read_python_nodes
from .reader import find_manifests, read_manifests
from .subtasks import NoTaskFiles, TaskFiles, TaskFolder, TaskTexts, face_of

__all__ = [
    "Catalog",
    "CodePath",
    "InputPort",
    "Manifest",
    "NoTaskFiles",
    "NodeId",
    "OutputPort",
    "OwnCode",
    "Parameter",
    "TaskFiles",
    "TaskFolder",
    "TaskTexts",
    "Type",
    "check_value",
    "face_of",
    "find_manifests",
    "find_python_nodes",
    "is_assignable",
    "load_implementation",
    "parse_type",
    "read_manifests",
    "read_python_nodes",
]
