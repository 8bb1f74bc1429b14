"""What the package offers, for type checkers and editors: each name is loaded on first use."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, TypedDict, Unpack

from grip_bt.app.building import NamedVariable, Part
from grip_bt.app.building import node as node
from grip_bt.app.building import variable as variable
from grip_bt.app.campaign.run import campaign as campaign
from grip_bt.app.python import Picture
from grip_bt.app.python import check as check
from grip_bt.app.python import draw as draw
from grip_bt.app.python import machine as machine
from grip_bt.app.python import tree as tree
from grip_bt.app.robot import Robot as Robot
from grip_bt.app.wiring.open import tree_run as tree_run
from grip_bt.app.wiring.parts import RobotKind
from grip_bt.app.world import World as World
from grip_bt.base.errors import GripError as GripError
from grip_bt.base.errors import NodeFailedError as NodeFailedError
from grip_bt.base.issue import Report
from grip_bt.base.ports import Context as Context
from grip_bt.compilers import to_machine as to_machine
from grip_bt.compilers import to_tree as to_tree
from grip_bt.formats.smach import from_machine as from_machine
from grip_bt.nodes import Leaf as Leaf
from grip_bt.nodes import OperationLeaf as OperationLeaf
from grip_bt.nodes.async_leaf import AsyncLeaf as AsyncLeaf
from grip_bt.nodes.async_leaf import End as End
from grip_bt.nodes.control import Control as Control
from grip_bt.nodes.function import Input as Input
from grip_bt.nodes.function import Output as Output
from grip_bt.nodes.function import Param as Param
from grip_bt.nodes.function import leaf as leaf
from grip_bt.nodes.leaf import Status as Status
from grip_bt.nodes.node import Observer as Observer
from grip_bt.runtime import BehaviourTree as BehaviourTree
from grip_bt.runtime import JournalReader as JournalReader
from grip_bt.runtime import RunResult as RunResult
from grip_bt.runtime import TreeRun as TreeRun
from grip_bt.runtime.ticked import Machine
from grip_bt.runtime.ticked import Tree as Tree
from grip_bt.task import Task as _Task
from grip_bt.task import dumps as dumps
from grip_bt.task.catalog import Catalog as Catalog

__version__: str

class Task(_Task):
    def check(self) -> Report: ...
    def tree(  # type: ignore[override]  # the rooms below know no more than that there are options
        self, robot: RobotKind = "fake", seed: int = 0, data: dict[str, Any] | None = None
    ) -> Tree: ...
    def machine(  # type: ignore[override]
        self, robot: RobotKind = "fake", seed: int = 0, data: dict[str, Any] | None = None
    ) -> Machine: ...
    def show(self, view: Literal["tree", "flow"] = "tree") -> Picture: ...

class _Options(TypedDict, total=False):
    target: Literal["bt", "sm"]
    robot: RobotKind
    seed: int
    object: str
    pace: float | None
    data: Mapping[str, Any]
    journal: Path | None
    rate: float | None
    watchdog: float | None
    mocks: Mapping[str, Sequence[Mapping[str, Any]]]
    ticks: int | None
    video: Path | None
    picture: Path | None
    view: str
    stand_ins: bool

def run(
    task: str | Path | _Task, *, observer: Observer | None = None, world: str | World = "", **options: Unpack[_Options]
) -> RunResult: ...
async def run_async(
    task: str | Path | _Task, *, observer: Observer | None = None, world: str | World = "", **options: Unpack[_Options]
) -> RunResult: ...
def load(path: Path | str) -> Task: ...
def loads(text: str, source: str = "") -> Task: ...
def build(
    name: str,
    root: Part,
    *,
    inputs: Sequence[NamedVariable] = (),
    outputs: Sequence[NamedVariable] = (),
    data: Sequence[NamedVariable] = (),
    outcomes: Mapping[str, str] | None = None,
    doc: str = "",
) -> Task: ...
def sequence(*children: Part, **fields: Any) -> Part: ...
def fallback(*children: Part, **fields: Any) -> Part: ...
def parallel(*children: Part, **fields: Any) -> Part: ...
def state_machine(*children: Part, **fields: Any) -> Part: ...
def retry(*children: Part, **fields: Any) -> Part: ...
def repeat(*children: Part, **fields: Any) -> Part: ...
def timeout(*children: Part, **fields: Any) -> Part: ...
def guard(*children: Part, **fields: Any) -> Part: ...
def switch(*children: Part, **fields: Any) -> Part: ...
def round_robin(*children: Part, **fields: Any) -> Part: ...
def for_each(*children: Part, **fields: Any) -> Part: ...
def loop(*children: Part, **fields: Any) -> Part: ...
def cooldown(*children: Part, **fields: Any) -> Part: ...
def control(*children: Part, **fields: Any) -> Part: ...
def once(*children: Part, **fields: Any) -> Part: ...
def foreign(*children: Part, **fields: Any) -> Part: ...
def subtask(*children: Part, **fields: Any) -> Part: ...
def invert(*children: Part, **fields: Any) -> Part: ...
def force(*children: Part, **fields: Any) -> Part: ...
