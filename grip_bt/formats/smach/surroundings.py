"""What legacy code takes from around it while it is recorded: as it is here, and known to be no more than that.

Environment, command line, time, chance, host and ROS parameters give stand-ins that hold what they are here (of a
parameter, the default), so that nothing hangs on them unseen. Files of the workspace are part of the program.
"""

from __future__ import annotations

import argparse
import datetime
import getpass
import io
import os
import platform
import random
import shutil
import socket
import sys
import time
import uuid
from collections.abc import Callable
from functools import lru_cache, partial
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any
from xml.etree import ElementTree

import yaml

from grip_bt.nodes import stand_ins
from grip_bt.nodes.smach_source import Workspace
from grip_bt.nodes.stand_ins import StandInFinder, known, lasting, lifted, name_of, stand_in, stand_in_class, stands_in
from grip_bt.smach_compat import smach_ros as real
from grip_bt.smach_compat.smach_ros._port import Ros

from .found import FIXED_OUTCOMES
from .tracked_code import SPECIAL, caller, is_tracked

_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC
_written: set[str] = set()
"""Files and folders that the program would have changed; what it reads of them isn't known any more."""
_CHANGING = (os.mkdir, os.makedirs, os.remove, os.unlink, os.rmdir, os.rename, shutil.rmtree, shutil.copy, shutil.move)
_REFUSED = (
    *("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.fork", "os.remove", "os.rename", "os.rmdir"),
    *("os.mkdir", "os.truncate", "os.chmod", "os.link", "os.symlink", "shutil.", "socket.connect", "socket.bind"),
    *("socket.sendto", "os.kill"),
)
_READING = ("open", "os.listdir", "os.scandir")
_is_refused = lru_cache(lambda event: event.startswith(_REFUSED))


def guard(workspace: Workspace, read: set[str]) -> None:
    """Refuse what building a machine doesn't need, for good; what is read of the workspace is added to `read`."""
    sys.dont_write_bytecode = True
    own, python = str(workspace.root) + os.sep, (sys.prefix, sys.base_prefix, "/proc/", "/dev/", "/usr/lib", "/etc/ssl")

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        refused = _is_refused(event)  # it comes with nearly all that Python does
        if not (refused or event in _READING) or caller() is None:
            return
        if refused:
            raise PermissionError(f"{event} isn't allowed while machines are recorded")
        mode, flags = arguments[1:3] if event == "open" else (None, 0)
        writes = any(c in mode for c in "wax+") if isinstance(mode, str) else bool(flags and int(flags) & _WRITING)
        if writes:
            raise PermissionError(f"writing {arguments[0]} isn't allowed while machines are recorded")
        named = isinstance(arguments[0], str) and arguments[0][:1] != "<"  # what has no file: texts, stand-ins
        path = os.path.abspath(arguments[0]) if named else ""
        if not path or path.endswith((".py", ".pyc", ".so")) or _importing():
            return
        if _changed(path):
            stand_ins.judge.note(f"the file {path}, which it changes")
        elif (path + os.sep).startswith(own):
            read.add(os.path.relpath(path, own))
        elif not path.startswith(python):
            stand_ins.judge.note(f"the file {path}")

    sys.addaudithook(hook)


def _importing() -> bool:
    frame = sys._getframe(2)
    while frame is not None and not is_tracked(frame):
        if "importlib" in frame.f_code.co_filename:
            return True
        frame = frame.f_back  # type: ignore[assignment]
    return False


def surround(workspace: Workspace) -> None:
    """Put what stands for the surroundings in their place, for good."""
    for module, names in _SEEN.items():
        for name in names:
            if (there := getattr(module, name, None)) is not None:
                SPECIAL[there] = partial(_seen, there, f"{getattr(module, '__name__', '')}.{name}()")
    for name in ("shuffle", "sample", "choices"):
        SPECIAL[getattr(random, name)] = partial(_by_chance, getattr(random, name), f"random.{name}()")
    SPECIAL[random.choice] = _chosen
    for name in ("exists", "isfile", "isdir"):
        SPECIAL[getattr(os.path, name)] = partial(_outside, getattr(os.path, name), name, str(workspace.root))
    for function in _CHANGING:
        SPECIAL[function] = _change
    SPECIAL[open] = _opened
    SPECIAL[os.getenv] = lambda key, default=None: lasting(f"${key}", os.getenv(key, default), default is not None)
    SPECIAL[input] = lambda *given: known("input()")
    SPECIAL[time.sleep] = lambda seconds: None
    setattr(os, "environ", _Environment(os.environ))  # noqa: B010 - the process is ours
    sys.argv = stand_in("sys.argv", [""])  # type: ignore[assignment]
    sys.stdin = stand_in("sys.stdin")
    argparse.ArgumentParser.parse_args = _parsed  # type: ignore[method-assign,assignment]
    argparse.ArgumentParser.parse_known_args = lambda *given: (_parsed(*given), [])  # type: ignore[method-assign,assignment]


_SEEN: dict[Any, tuple[str, ...]] = {
    random: ("random", "randint", "uniform", "gauss", "randrange", "getrandbits", "normalvariate"),
    time: ("time", "monotonic", "perf_counter", "localtime", "gmtime", "strftime", "ctime", "time_ns"),
    datetime.datetime: ("now", "utcnow", "today"),
    datetime.date: ("today",),
    uuid: ("uuid1", "uuid4"),
    socket: ("gethostname", "getfqdn"),
    platform: ("node", "system", "machine", "platform"),
    getpass: ("getuser",),
    os: ("getpid", "getcwd", "getlogin", "cpu_count"),
}


def _seen(function: Callable[..., Any], name: str, *arguments: Any, **named: Any) -> Any:
    given = stand_ins.judge.known
    return given[name] if name in given else lifted(function, name, *arguments, **named)


def _change(*paths: Any, **named: Any) -> None:
    """Change nothing, and keep what would be changed."""
    named_here = (path for path in paths if isinstance(path, (str, os.PathLike)) and not stands_in(path))
    _written.update(os.path.abspath(path) for path in named_here)


def _changed(path: str) -> bool:
    return any(f"{each}{os.sep}".startswith(f"{path}{os.sep}") for each in _written)


def _opened(path: Any, mode: Any = "r", *rest: Any, **named: Any) -> Any:
    if not stands_in(mode) and set("wax+") & {*mode}:
        _change(path)
        return io.BytesIO() if "b" in mode else io.StringIO()
    read = partial(lifted, open, name_of(path)) if stands_in(path) else open
    return read(path, mode, *rest, **named)


def _by_chance(function: Callable[..., Any], name: str, *arguments: Any, **named: Any) -> Any:
    stand_ins.judge.note(name)
    return function(*arguments, **named)


def _chosen(items: Any) -> Any:
    made = _seen(random.choice, "random.choice()", items)
    kinds = {type(each) for each in items} if isinstance(items, (list, tuple)) else set()
    return stand_ins.surely(kinds.pop(), made) if len(kinds) == 1 and kinds <= {str, int, float, bool} else made


def _outside(function: Callable[[Any], bool], name: str, root: str, path: Any) -> Any:
    if stands_in(path):
        return lifted(function, name_of(path), path)
    there = function(path)
    known = os.path.abspath(path).startswith(root) and not _changed(os.path.abspath(path))
    return there if known else stand_in(f"os.path.{name}({str(path)!r})", there)


def _is_legacy_caller() -> bool:
    """Whether legacy code asks the environment: by a subscript, or by a call that was compiled into it."""
    frame = sys._getframe(2)
    return is_tracked(frame.f_back if frame.f_code.co_name == "_call" else frame)


def _is_set(key: object, here: bool = False) -> bool:
    """Whether a variable is set: as was said, of which null is that it isn't, or surely `here`."""
    given, name = stand_ins.judge.known, f"${key}"
    return given[name] is not None if name in given else here or stand_ins.judge.decide(f"{name} is set", True)


class _Environment(dict[str, str]):
    """The environment; legacy code gets it as stand-ins."""

    def __getitem__(self, key: str) -> Any:
        if not _is_legacy_caller():
            return super().__getitem__(key)
        if _is_set(key, super().__contains__(key)):
            return lasting(f"${key}", super().get(key, stand_ins.UNKNOWN), True)
        raise KeyError(key)

    def get(self, key: str, default: Any = None) -> Any:
        value = super().get(key, default)
        return lasting(f"${key}", value, default is not None) if _is_legacy_caller() else value

    def __contains__(self, key: object) -> bool:
        return _is_set(key) if _is_legacy_caller() else super().__contains__(key)

    def __iter__(self) -> Any:
        if _is_legacy_caller():
            stand_ins.judge.note("the environment")
        return super().__iter__()


def _parsed(parser: argparse.ArgumentParser, *given: Any) -> argparse.Namespace:
    """Return the arguments of a command line without any: defaults, and what nobody knows."""
    found = argparse.Namespace(**parser._defaults)
    for action in parser._actions:
        if action.dest != "help":
            name = f"the argument {action.dest}"
            needed = action.required or not action.option_strings
            setattr(found, action.dest, known(name) if needed else known(name, action.default))
    return found


def _packages(workspace: Workspace, packs: Any) -> None:
    """Have rospkg tell of packages what the `package.xml` files of the workspace say."""

    def manifest(name: Any) -> Any:
        file = None if stands_in(name) or name not in workspace.packages else workspace.packages[name] / "package.xml"
        return ElementTree.parse(file).getroot() if file is not None and file.is_file() else ()

    def depending(self: object, name: Any, implicit: bool = True) -> list[str]:
        direct = [p for p in workspace.packages if name in {e.text for e in manifest(p) if e.tag.endswith("depend")}]
        return sorted({*direct, *(d for p in direct for d in depending(self, p))} if implicit else direct)

    def described(self: object, name: Any) -> Any:
        made, found = stand_in("manifest"), manifest(name)
        if len(found):
            exported = lambda tag, key: [e.get(key) for e in found.findall(f"export/{tag}") if e.get(key)]  # noqa: E731
            vars(made)["get_export"] = exported
        return made

    packs.get_depends_on, packs.get_manifest = depending, described


_ABSENT: Any = object()


def _in_namespace(name: str) -> Any:
    """Return a ROS parameter of a namespace of which somebody has said all that is in it; UNKNOWN if nobody has."""
    parts = name.strip("/").split("/")
    for number in range(len(parts) - 1, -1, -1):
        for begin in ("ROS parameter /", "ROS parameter "):
            found = stand_ins.judge.known.get(begin + "/".join(parts[:number]))
            if isinstance(found, dict):
                for part in parts[number:]:
                    found = found.get(part, _ABSENT) if isinstance(found, dict) else _ABSENT
                return found
    return stand_ins.UNKNOWN


def _rosparam(module: ModuleType) -> None:
    """Have parameters that a program uploads be those that it reads."""

    def load(file: Any, default_namespace: str | None = None, verbose: bool = False) -> Any:
        if stands_in(file):
            return stand_in(f"parameters of {name_of(file)}")
        with open(file) as text:
            return [(yaml.safe_load(text), default_namespace or "/")]

    def upload(ns: Any, values: Any, verbose: bool = False) -> None:
        for name, value in values.items() if isinstance(values, dict) and not stands_in(ns) else ():
            stand_ins.judge.known[f"ROS parameter {ns.rstrip('/')}/{name}"] = value

    _give(module, load_file=load, upload_params=upload)


def _give(module: ModuleType, **functions: Any) -> None:
    """Give a module functions that take stand-ins as they are."""
    for name, function in functions.items():
        function._stand_in_free = True
        setattr(module, name, function)


_ROSLIB_PACKAGES = ModuleSpec("roslib.packages", None)


def ros_stand_ins(finder: StandInFinder, workspace: Workspace) -> None:
    """Give packages of ROS that aren't here what construction needs of them."""

    def rospy(module: ModuleType) -> None:
        def parameter(name: Any, default: Any = stand_ins.UNKNOWN) -> Any:
            found = stand_ins.UNKNOWN if stands_in(name) else _in_namespace(name)
            if found is _ABSENT and default is stand_ins.UNKNOWN:
                raise KeyError(name)
            if found is not stand_ins.UNKNOWN:
                return default if found is _ABSENT else found
            return lasting(f"ROS parameter {name}", default, default is not None)

        def there(name: Any) -> Any:
            found = parameter(name, _ABSENT)
            return stand_in(f"ROS parameter {name}", wanted=False) if stands_in(found) else found is not _ABSENT

        _give(module, get_param=parameter, has_param=there, myargv=lambda *given, **named: sys.argv)
        _give(module, is_shutdown=lambda: stand_in("rospy.is_shutdown()"))

    def folder(name: Any, *rest: Any) -> Any:
        found = None if stands_in(name) else workspace.packages.get(name)
        return stand_in(f"the folder of {name}") if found is None else str(found)

    def smach_ros(module: ModuleType) -> None:
        port: Any = Ros(stand_in)
        port.name_of = lambda name, node: name  # which may be a stand-in
        real.use(port)
        for name in (*FIXED_OUTCOMES, "RosState"):
            setattr(module, name, getattr(real, name))

    def rospkg(module: ModuleType) -> None:
        module.RosPack = stand_in_class("RosPack")  # type: ignore[attr-defined]
        _packages(workspace, module.RosPack)
        module.RosPack.get_path = lambda self, name: folder(name)

    finder.made |= {"rospy": rospy, "rosparam": _rosparam, "rospkg": rospkg}
    modules = ("action_server_wrapper", "condition_state", "monitor_state", "service_state", "simple_action_state")
    finder.made |= dict.fromkeys(("smach_ros", *(f"smach_ros.{name}" for name in modules)), smach_ros)
    share = ("ament_index_python", "ament_index_python.packages")
    finder.made |= dict.fromkeys(share, lambda module: setattr(module, "get_package_share_directory", folder))
    finder.made["roslib.packages"] = lambda module: setattr(module, "get_pkg_dir", folder)
    finder.made["roslib"] = lambda module: setattr(module, "packages", finder.create_module(_ROSLIB_PACKAGES))
