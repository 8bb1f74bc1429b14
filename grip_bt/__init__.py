"""GRIP: robot grasping tasks as one graph, run as a behaviour tree or as a state machine.

Importing this package loads no ROS, no simulator, no web server and no numerics; each public name is loaded on
first use.
"""

import sys

if sys.argv[:1] == ["-m"] and not sys.flags.safe_path and {"grip_bt.cli", "grip_bt.cli.__main__"} & {*sys.orig_argv}:
    del sys.path[0]  # `python -m grip_bt.cli`: a `random.py` of the current folder isn't Python's

from functools import partial
from importlib import import_module

__version__ = "0.1.0"

_HOME = {
    "GripError": "grip_bt.base.errors",
    "Task": "grip_bt.task",
    "load": "grip_bt.task",
    "loads": "grip_bt.task",
    "dumps": "grip_bt.task",
    "Catalog": "grip_bt.task.catalog",
    "build": "grip_bt.app.building",
    "node": "grip_bt.app.building",
    "variable": "grip_bt.app.building",
    "check": "grip_bt.app.python",
    "draw": "grip_bt.app.python",
    "tree": "grip_bt.app.python",
    "machine": "grip_bt.app.python",
    "Tree": "grip_bt.runtime.ticked",
    "Observer": "grip_bt.nodes.node",
    "Robot": "grip_bt.app.robot",
    "World": "grip_bt.app.world",
    "NodeFailedError": "grip_bt.base.errors",
    "RunResult": "grip_bt.runtime",
    "JournalReader": "grip_bt.runtime",
    "to_tree": "grip_bt.compilers",
    "to_machine": "grip_bt.compilers",
    "Leaf": "grip_bt.nodes",
    "OperationLeaf": "grip_bt.nodes",
    "AsyncLeaf": "grip_bt.nodes.async_leaf",
    "Control": "grip_bt.nodes.control",
    "leaf": "grip_bt.nodes.function",
    "End": "grip_bt.nodes.async_leaf",
    "Input": "grip_bt.nodes.function",
    "Output": "grip_bt.nodes.function",
    "Param": "grip_bt.nodes.function",
    "Context": "grip_bt.base.ports",
    "Status": "grip_bt.nodes.leaf",
    "from_machine": "grip_bt.formats.smach",
    "BehaviourTree": "grip_bt.runtime",
    "TreeRun": "grip_bt.runtime",
    "tree_run": "grip_bt.app.wiring.open",
    "campaign": "grip_bt.app.campaign.run",
    "run": "grip_bt.app.runs.execute",
    "run_async": "grip_bt.app.runs.execute",
}

__all__ = [*_HOME]


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    if name[:1] != "_" and name in import_module("grip_bt.task.kinds").KINDS:  # `grip.sequence(...)`
        return partial(import_module("grip_bt.app.building").container, name)
    raise AttributeError(f"module 'grip_bt' has no attribute {name!r}")


def __dir__() -> list[str]:
    return ["__version__", *sorted(__all__)]
