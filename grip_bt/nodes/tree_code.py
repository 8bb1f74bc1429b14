"""Somebody's tree of py_trees, as their own code makes it: a function, a class, an object, or a program that ticks it.

This imports and runs that code: whoever calls it has been told to. A program, or a function such as `main`, is run
until it ticks its tree for the first time; that tree, with its handlers and visitors, is what is found.
"""

from __future__ import annotations

import ast
import asyncio
import ctypes
import importlib.util
import inspect
import re
import shlex
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn
from unittest import mock

from py_trees.behaviour import Behaviour
from py_trees.trees import BehaviourTree

from grip_bt.base.errors import GripError, listing
from grip_bt.nodes import stand_ins
from grip_bt.nodes.older_py_trees import older_calls, take_older_setups
from grip_bt.nodes.smach_source import package_of, workspace_of

_WHERE = re.compile(
    r"(?P<module>[^:()]+?\.py|[^:()\s]+)(?::(?P<name>[A-Za-z_][\w.]*)(?P<call>\(.*\))?)?(?P<words>\s.*)?"
)
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
    """Where a tree's code is: a module or a file, a name in it with dots, and literals with which that is called.

    `words`: the command line that a program finds.
    """

    module: str
    name: str = PROGRAM
    arguments: Mapping[str, object] = field(default_factory=dict)
    words: tuple[str, ...] = ()

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
    of_other_kind = Path(text).suffix.lower() in (".yaml", ".yml", ".xml")
    return re.search(r"\.py([\s:]|$)", text) is not None or (":" in text and not of_other_kind)


def place_of(text: str) -> Place:
    """Read `package.module:function`, `file.py:function(argument=1)` or `file.py --option`. Raises TreeCodeError."""
    found = _WHERE.fullmatch(text.strip())
    if found is None:
        raise TreeCodeError(f"{text!r} names no tree: {_ADVICE}")
    try:
        call = ast.parse(f"f{found['call'] or '()'}", mode="eval").body
        given = call.keywords if isinstance(call, ast.Call) and not call.args else [ast.keyword(None, call)]
        arguments = {str(each.arg): ast.literal_eval(each.value) for each in given}
        words = tuple(shlex.split(found["words"] or ""))
    except (SyntaxError, ValueError):
        raise TreeCodeError(f"{text!r}: arguments are literals by name, such as `(level=3)`") from None
    return Place(found["module"], found["name"] or PROGRAM, arguments, words)


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
            value = _made(place, node, watched)
        except (TreeCodeError, KeyboardInterrupt):
            raise
        except BaseException as error:
            if watched.ticked is not None:
                return watched.found(watched.ticked)
            raise TreeCodeError(f"{place.module}: {_told(error)}") from error
    tree = _tree_in(value) or (watched.made[-1] if watched.made and value is None else None)
    if tree is None:
        what, there = (
            ("and ticks none", [f"{place.module}:{name}" for name in watched.functions])
            if value is None
            else (f"but a {type(value).__name__}", [f"{place.name}.{name}" for name in _functions(type(value))])
        )
        raise TreeCodeError(f"{place.module}:{place.name} makes no tree of py_trees {what}{_there(there)}")
    return watched.found(tree)


def _functions(owner: object) -> list[str]:
    mine = {name: each for name, each in vars(owner).items() if inspect.isfunction(each) and name[0] != "_"}
    module = owner.__name__ if inspect.ismodule(owner) else owner.__module__
    return [name for name, each in mine.items() if each.__module__ == module]


def _there(names: list[str]) -> str:
    return f" (there are: {listing(names)})" if names else ""


def _told(error: BaseException) -> str:
    if isinstance(error, ImportError):
        how = "install or build it here, run grip where its workspace is set up, or stand in for it with --stand-ins"
        return f"{error}, which the code imports: {how}"
    if isinstance(error, SystemExit):
        return f"SystemExit: {error}; what its command line needs goes behind it: `grip run 'demo.py --help'`"
    return f"{type(error).__name__}: {error}"


def _made(place: Place, node: Callable[[], object] | None, watched: _Watched) -> Any:
    """Return what the name means, called if it can be; a method is one of an object that is made for it."""
    with mock.patch.object(sys, "argv", [place.module, *place.words]):
        value: Any = _module(place)
        watched.functions = _functions(value)
        if place.name == PROGRAM:
            return next((each for name in _HOLDERS if (each := vars(value).get(name)) is not None), None)
        arguments = dict(place.arguments)
        for part in place.name.split("."):
            if not hasattr(value, part):
                raise TreeCodeError(f"{place.module} has no {part!r}{_there(_functions(value))}")
            owner, value = value, getattr(value, part)
            if isinstance(owner, type) and inspect.isfunction(inspect.getattr_static(owner, part)):
                mine = {name: arguments.pop(name) for name in parameters_of(owner) if name in arguments}
                value = getattr(owner(**_arguments(owner, place, node, mine)), part)
        if isinstance(value, Behaviour | BehaviourTree) or not callable(value):
            return value
        made = value(**_arguments(value, place, node, arguments))
        return asyncio.run(made) if inspect.iscoroutine(made) else made


def _module(place: Place) -> Any:
    file, (folder, name) = place.file, place.found_at()
    if file is not None and not file.is_file():
        raise TreeCodeError(f"{file}: there is no such file; {_ADVICE}")
    for each in (folder,) if file is None else workspace_of(file.resolve()).folders:
        if str(each) not in sys.path:
            sys.path.append(str(each))  # last: nothing there takes the place of what is installed
    if place.name != PROGRAM:
        return importlib.import_module(name)
    as_script = file is not None and re.search(r"^\s*from \.", file.read_text(errors="replace"), re.M) is None
    spec = importlib.util.spec_from_file_location(PROGRAM, file) if as_script else importlib.util.find_spec(name)
    loader: Any = spec.loader if spec is not None else None
    if spec is None or loader is None:
        raise ModuleNotFoundError(f"No module named {name!r}")
    module = importlib.util.module_from_spec(spec)
    module.__name__, module.__package__ = PROGRAM, "" if as_script else name.rpartition(".")[0]
    before, sys.modules[PROGRAM] = sys.modules[PROGRAM], module
    try:
        exec(loader.get_code(spec.name), vars(module))
    finally:
        sys.modules[PROGRAM] = before
    return module


def parameters_of(function: Callable[..., object]) -> Mapping[str, inspect.Parameter]:
    """Return what a function or class takes; nothing where that isn't known."""
    try:
        return inspect.signature(function).parameters
    except (TypeError, ValueError):
        return {}


def _arguments(
    function: Callable[..., object], place: Place, node: Callable[[], object] | None, given: dict[str, object]
) -> dict[str, object]:
    """Return what a function is called with: what is given, a ROS node, and what stands in, where that is wanted."""
    for name, parameter in parameters_of(function).items():
        many = parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD)
        if name in given or many or parameter.default is not parameter.empty:
            continue
        if node is not None and "node" in f"{name} {parameter.annotation}".lower() and parameter.annotation is not str:
            given[name] = node()
        elif stand_ins.are_wanted():
            given[name] = name if parameter.annotation in (str, "str") else stand_ins.stand_in(name)
        else:
            said = f"{place.module}:{place.name}({name}=...)"
            raise TreeCodeError(f"{place.name} takes {name!r}: give it as a literal, `{said}`, or use --stand-ins")
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


class _TickedError(SystemExit):
    """Somebody's program ticks its tree: it has done its part. Passes every `except Exception`, and threads quietly."""


class _Watched:
    def __init__(self) -> None:
        self.ticked: BehaviourTree | None = None
        self.thread = threading.get_ident()
        self.made: list[BehaviourTree] = []
        self.ready: list[BehaviourTree] = []
        self.functions: list[str] = []
        self.period: float | None = None

    def leave(self, tree: BehaviourTree) -> NoReturn:
        """Leave the code that ticks a tree; what ticks it in a thread of its own, such as an executor, has others."""
        self.ticked = self.ticked or tree
        if threading.get_ident() != self.thread:
            here, error = ctypes.c_ulong(self.thread), ctypes.py_object(_TickedError)
            ctypes.pythonapi.PyThreadState_SetAsyncExc(here, error)
        raise _TickedError

    def found(self, tree: BehaviourTree) -> FoundTree:
        take_older_setups(tree.root)
        return FoundTree(tree, any(each is tree for each in self.ready), self.period)


@contextmanager
def _watching(watched: _Watched) -> Iterator[None]:
    """Note which trees are made and set up, and stop at the first tick; nothing is shut down on the way out."""
    make, setup = BehaviourTree.__init__, BehaviourTree.setup

    def made(self: BehaviourTree, root: Behaviour) -> None:
        make(self, root)
        watched.made.append(self)

    def set_up(self: BehaviourTree, *args: object, **kwargs: object) -> None:
        take_older_setups(self.root)
        setup(self, *args, **kwargs)
        watched.ready.append(self)

    def tick(self: BehaviourTree, pre_tick_handler: Any = None, post_tick_handler: Any = None) -> None:
        self.pre_tick_handlers += [pre_tick_handler] if pre_tick_handler else []
        self.post_tick_handlers += [post_tick_handler] if post_tick_handler else []
        _keep_ros()
        watched.leave(self)

    def tick_tock(self: BehaviourTree, period_ms: float, *args: object, **kwargs: object) -> None:
        given = inspect.signature(original).bind(self, period_ms, *args, **kwargs).arguments
        watched.period = float(period_ms) / 1000
        tick(self, given.get("pre_tick_handler"), given.get("post_tick_handler"))

    def tick_once(self: Behaviour) -> None:
        tree = _tree_in(self)
        assert tree is not None, "a behaviour is in a tree"
        watched.leave(next((each for each in watched.made if each.root is tree.root), tree))

    original = BehaviourTree.tick_tock
    replaced: dict[str, Any] = {
        "__init__": made,
        "setup": set_up,
        "tick": tick,
        "tick_tock": tick_tock,
        "shutdown": lambda self: None,
    }
    with (
        mock.patch.multiple(BehaviourTree, **replaced),
        mock.patch.object(Behaviour, "tick_once", tick_once),
        older_calls(),
    ):
        yield


def is_of_ros(root: Behaviour) -> bool:
    """Tell whether the code of a tree's behaviours uses rclpy, or has a ROS node given to `setup`."""
    classes: set[Any] = {cls for each in root.iterate() for cls in type(each).__mro__}
    names = {cls.__module__ for cls in classes}
    used = {str(getattr(v, "__module__", "")) for m in names for v in vars(sys.modules.get(m, object)).values()}
    used |= {v.__name__ for m in names for v in vars(sys.modules.get(m, object)).values() if inspect.ismodule(v)}
    of_ros = any(name.split(".")[0] in ("rclpy", "py_trees_ros") for name in names | used)
    setups = [cls.setup for cls in classes if issubclass(cls, Behaviour)]  # `kwargs["node"]` is a constant of its code
    return of_ros or any("node" in (*parameters_of(each), *each.__code__.co_consts) for each in setups)


def _keep_ros() -> None:
    """Have ROS stay as it is when somebody's program is left: what it does in the end isn't meant yet."""
    rclpy: object = sys.modules.get("rclpy")
    for name in ("shutdown", "try_shutdown") if rclpy is not None else ():
        _once_nothing(rclpy, name, getattr(rclpy, name))


def _once_nothing(owner: object, name: str, original: object) -> None:
    setattr(owner, name, lambda *_, **__: setattr(owner, name, original))
