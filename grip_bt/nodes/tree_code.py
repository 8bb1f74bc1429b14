"""Somebody's tree of py_trees, as their own code makes it: a function, a class, an object, or a program that ticks it.

This imports and runs that code: whoever calls it has been told to. A program, or a function such as `main`, is run
until it ticks its tree for the first time; that tree, with its handlers and visitors, is what is found.
"""

from __future__ import annotations

import ast
import importlib.util
import inspect
import re
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest import mock

from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy
from py_trees.composites import Parallel, Selector, Sequence
from py_trees.trees import BehaviourTree

from grip_bt.base.errors import GripError, listing
from grip_bt.nodes.smach_source import package_of

_WHERE = re.compile(r"(?P<module>[^:()]+?)(?::(?P<name>[A-Za-z_][\w.]*)(?P<call>\(.*\))?)?")
_HOLDERS = ("root", "tree", "behaviour_tree", "behavior_tree", "bt", "_tree", "_root")
"""Attributes in which objects have their tree."""
PROGRAM = "__main__"
_ADVICE = "write module:function or file.py:function; arguments go in brackets: `demo.py:make_tree(level=3)`"


class TreeCodeError(GripError):
    """Somebody's code can't be imported, fails, or makes no tree."""


@dataclass
class FoundTree:
    """A tree; `ready`: its code has set it up; `period`: how often it is to be ticked [s], where that was said."""

    tree: BehaviourTree
    ready: bool = False
    period: float | None = None


@dataclass(frozen=True)
class Place:
    """Where a tree's code is: a module or a file, a name in it with dots, and literals with which that is called."""

    module: str
    name: str = PROGRAM
    arguments: Mapping[str, object] = field(default_factory=dict)

    @property
    def file(self) -> Path | None:
        """The file, where one was named."""
        return Path(self.module) if self.module.endswith(".py") else None

    def found_at(self) -> tuple[Path, str]:
        """Return the folder where its module is looked for, and the module's name there."""
        file = self.file
        if file is None:
            return Path.cwd(), self.module
        return package_of(file.resolve())

    @property
    def import_name(self) -> str:
        """The name by which its module is imported."""
        return self.found_at()[1]


def is_tree_code(text: str) -> bool:
    """Tell whether somebody names code that makes a tree, and no file of another kind."""
    return (":" in text or text.endswith(".py")) and Path(text).suffix.lower() not in (".yaml", ".yml", ".xml")


def place_of(text: str) -> Place:
    """Read `package.module:function`, `file.py:function(argument=1)` or `file.py`. Raises TreeCodeError."""
    found = _WHERE.fullmatch(text.strip())
    if found is None:
        raise TreeCodeError(f"{text!r} names no tree: {_ADVICE}")
    try:
        call = ast.parse(f"f{found['call'] or '()'}", mode="eval").body
        given = call.keywords if isinstance(call, ast.Call) and not call.args else [ast.keyword(None, call)]
        arguments = {str(each.arg): ast.literal_eval(each.value) for each in given}
    except (SyntaxError, ValueError):
        raise TreeCodeError(f"{text!r}: arguments are literals by name, such as `(level=3)`") from None
    return Place(found["module"], found["name"] or PROGRAM, arguments)


def find_tree(place: Place, node: Callable[[], object] | None = None) -> FoundTree:
    """Run the code and return the tree that it makes.

    Args:
        node: gives the ROS node that a function may take as its argument `node`.

    Raises:
        TreeCodeError: the code can't be imported, fails, or makes no tree.
    """
    watched = _Watched()
    with _watching(watched):
        try:
            value = _made(place, node)
        except _TickedError as ticked:
            return watched.found(ticked.tree)
        except TreeCodeError:
            raise
        except BaseException as error:
            if isinstance(error, KeyboardInterrupt):
                raise
            raise TreeCodeError(f"{place.module}: {_told(error)}") from error
    tree = _tree_in(value) or (watched.made[-1] if watched.made and value is None else None)
    if tree is None:
        what = "and ticks none" if value is None else f"but a {type(value).__name__}"
        raise TreeCodeError(f"{place.module}:{place.name} makes no tree of py_trees {what}")
    return watched.found(tree)


def _told(error: BaseException) -> str:
    if isinstance(error, ModuleNotFoundError):
        return f"{error}, which the code imports: install it here, or run grip from its workspace"
    return f"{type(error).__name__}: {error}"


def _made(place: Place, node: Callable[[], object] | None) -> Any:
    """Return what the name means, called if it can be."""
    with mock.patch.object(sys, "argv", [place.module]):
        module = _module(place)
        if place.name == PROGRAM:
            return next((each for name in _HOLDERS if (each := vars(module).get(name)) is not None), None)
        value: Any = module
        for part in place.name.split("."):
            if not hasattr(value, part):
                there = [name for name, each in vars(module).items() if inspect.isfunction(each)]
                raise TreeCodeError(f"{place.module} has no {part!r} (functions: {listing(there) or 'none'})")
            value = getattr(value, part)
        if isinstance(value, Behaviour | BehaviourTree) or not callable(value):
            return value
        return value(**_arguments(value, place, node))


def _module(place: Place) -> Any:
    file, (folder, name) = place.file, place.found_at()
    if file is not None and not file.is_file():
        raise TreeCodeError(f"{file}: there is no such file; {_ADVICE}")
    if str(folder) not in sys.path:
        sys.path.append(str(folder))  # last: nothing there takes the place of what is installed
    if place.name != PROGRAM:
        return importlib.import_module(name)
    spec = importlib.util.find_spec(name)
    loader: Any = spec.loader if spec is not None else None
    if spec is None or loader is None:
        raise ModuleNotFoundError(f"No module named {name!r}")
    module = importlib.util.module_from_spec(spec)
    module.__name__ = PROGRAM
    before, sys.modules[PROGRAM] = sys.modules[PROGRAM], module
    try:
        exec(loader.get_code(name), vars(module))
    finally:
        sys.modules[PROGRAM] = before
    return module


def _arguments(function: Any, place: Place, node: Callable[[], object] | None) -> dict[str, Any]:
    try:
        wanted = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return dict(place.arguments)
    given = dict(place.arguments)
    for parameter in wanted:
        if parameter.name in given or parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        if parameter.default is parameter.empty:
            if node is None or "node" not in f"{parameter.name} {parameter.annotation}".lower():
                said = f"{place.module}:{place.name}({parameter.name}=...)"
                raise TreeCodeError(f"{place.name} takes {parameter.name!r}: give it as a literal, `{said}`")
            given[parameter.name] = node()
    return given


def _tree_in(value: Any, deeper: bool = True) -> BehaviourTree | None:
    if isinstance(value, BehaviourTree):
        return value
    if isinstance(value, Behaviour):
        while value.parent is not None:
            value = value.parent
        return BehaviourTree(value)
    inside = value if isinstance(value, tuple | list) else [getattr(value, name, None) for name in _HOLDERS]
    return next((tree for each in inside if (tree := _tree_in(each, False)) is not None), None) if deeper else None


class _TickedError(BaseException):
    """Somebody's program ticks its tree: it has done its part. Passes every `except Exception`."""

    def __init__(self, tree: BehaviourTree):
        self.tree = tree


class _Watched:
    def __init__(self) -> None:
        self.made: list[BehaviourTree] = []
        self.ready: list[BehaviourTree] = []
        self.period: float | None = None

    def found(self, tree: BehaviourTree) -> FoundTree:
        return FoundTree(tree, any(each is tree for each in self.ready), self.period)


@contextmanager
def _watching(watched: _Watched) -> Iterator[None]:
    """Note which trees are made and set up, and stop at the first tick; nothing is shut down on the way out."""
    make, setup = BehaviourTree.__init__, BehaviourTree.setup

    def made(self: BehaviourTree, root: Behaviour) -> None:
        make(self, root)
        watched.made.append(self)

    def set_up(self: BehaviourTree, *args: Any, **kwargs: Any) -> None:
        setup(self, *args, **kwargs)
        watched.ready.append(self)

    def tick(self: BehaviourTree, pre_tick_handler: Any = None, post_tick_handler: Any = None) -> None:
        self.pre_tick_handlers += [pre_tick_handler] if pre_tick_handler else []
        self.post_tick_handlers += [post_tick_handler] if post_tick_handler else []
        _keep_ros()
        raise _TickedError(self)

    def tick_tock(self: BehaviourTree, period_ms: float, *args: Any, **kwargs: Any) -> None:
        given = inspect.signature(original).bind(self, period_ms, *args, **kwargs).arguments
        watched.period = float(period_ms) / 1000
        tick(self, given.get("pre_tick_handler"), given.get("post_tick_handler"))

    def tick_once(self: Behaviour) -> None:
        tree = _tree_in(self)
        assert tree is not None, "a behaviour is in a tree"
        raise _TickedError(next((each for each in watched.made if each.root is tree.root), tree))

    original = BehaviourTree.tick_tock
    old: Any = {"SUCCESS_ON_ALL": ParallelPolicy.SuccessOnAll(), "SUCCESS_ON_ONE": ParallelPolicy.SuccessOnOne()}
    replaced: dict[str, Any] = {
        "__init__": made,
        "setup": set_up,
        "tick": tick,
        "tick_tock": tick_tock,
        "shutdown": lambda self: None,
    }
    before = {
        Sequence: ("Sequence", True),
        Selector: ("Selector", False),
        Parallel: ("Parallel", old["SUCCESS_ON_ALL"]),
    }
    with ExitStack() as patched:
        patched.enter_context(mock.patch.multiple(BehaviourTree, **replaced))
        patched.enter_context(mock.patch.object(Behaviour, "tick_once", tick_once))
        patched.enter_context(mock.patch.multiple(ParallelPolicy, create=True, **old))
        for cls, defaults in before.items():  # before py_trees 2.2 composites had defaults
            patched.enter_context(mock.patch.object(cls.__init__, "__defaults__", (*defaults, None)))
        yield


def _keep_ros() -> None:
    """Have ROS stay as it is when somebody's program is left: what it does in the end isn't meant yet."""
    rclpy: Any = sys.modules.get("rclpy")
    for name in ("shutdown", "try_shutdown") if rclpy is not None else ():
        _once_nothing(rclpy, name, getattr(rclpy, name))


def _once_nothing(owner: Any, name: str, original: Any) -> None:
    setattr(owner, name, lambda *_, **__: setattr(owner, name, original))
