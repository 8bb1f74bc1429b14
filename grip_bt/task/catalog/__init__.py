"""What nodes exist: their manifests, the types of their ports, and the way to their code."""

from grip_bt.base.types import Type, check_value, is_assignable, parse_type

from .catalog import Catalog, load_implementation
from .manifest import InputPort, Manifest, NodeId, OutputPort, Parameter, find_manifests, read_manifests
from .python_nodes import find_python_nodes, read_python_nodes
from .source_code import AllowedImports, CodePath
from .task_files import TaskFiles, TaskFolder, TaskTexts, manifest_of_task

__all__ = [
    "Catalog",
    "CodePath",
    "InputPort",
    "Manifest",
    "NodeId",
    "OutputPort",
    "AllowedImports",
    "Parameter",
    "TaskFiles",
    "TaskFolder",
    "TaskTexts",
    "Type",
    "check_value",
    "manifest_of_task",
    "find_manifests",
    "find_python_nodes",
    "is_assignable",
    "load_implementation",
    "parse_type",
    "read_manifests",
    "read_python_nodes",
]
