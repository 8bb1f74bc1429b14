"""From a launch file to the processes that it asks for; arguments, conditions, groups and includes resolved."""

from __future__ import annotations

import math
import os
import shlex
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from grip_bt.base.errors import listing, nearest
from grip_bt.ros.interfaces.packages import PackageError, executable_of

from ..process import child_environment
from .element import Element, LaunchError, read_elements
from .group import Member
from .substitutions import LaunchContext, substitute, truth

DEEPEST = 30
"""Files that include each other."""
_CONDITIONS = {"if", "unless"}


SUFFIXES = (".launch.py", ".launch.xml", ".launch.yaml", ".launch.yml", ".launch", ".xml", ".yaml", ".yml", ".py")


def is_launch_file(name: str) -> bool:
    """Tell whether a name is that of a launch file."""
    return name.endswith(SUFFIXES)


def members_of_file(path: Path, arguments: Mapping[str, str], own_reader: bool = False) -> list[Member]:
    """Return the processes that run a launch file.

    With ROS's tools there is one, which sees to all others; without them, one for each node and executable.

    Args:
        own_reader: whether our own reader is used also where ROS's tools are.

    Raises:
        LaunchError: the file can't be run here; it says why, and what to do.
    """
    if not path.is_file():
        raise LaunchError(str(path), None, "there is no such file")
    env = child_environment(())
    given = [f"{name}:={value}" for name, value in arguments.items()]
    ros2 = None if own_reader else shutil.which("ros2")
    if ros2 is not None:
        return [Member(path.name, [ros2, "launch", str(path), *given], Path.cwd(), env)]
    return read_launch_file(path, arguments, env)


def read_launch_file(
    path: Path | str,
    arguments: Mapping[str, str] | None = None,
    env: Mapping[str, str] | None = None,
) -> list[Member]:
    """Read an XML or YAML launch file and return the processes that it asks for.

    Args:
        env: what its processes inherit; nothing by default.

    Raises:
        LaunchError: it is wrong, asks for something that isn't here, or uses what isn't understood; by name and line.
    """
    reader = _Reader(env or {})
    reader.read_file(Path(path), dict(arguments or {}), _Scope({}, {}), ())
    return reader.processes


@dataclass
class _Scope:
    """What a group has of its own; children change a copy, elements of one group share it.

    Attributes:
        env: environment variables that were set; None for those that were taken away.
        ros_args: remappings and parameters of all nodes.
        after: how long after the beginning it all happens [s].
    """

    variables: dict[str, str]
    env: dict[str, str | None]
    namespace: str = ""
    ros_args: tuple[str, ...] = ()
    after: float = 0.0

    def copy(self) -> _Scope:
        """Return one that can be changed without changing this."""
        return replace(self, variables=dict(self.variables), env=dict(self.env))

    def within(self, namespace: str) -> str:
        """Return a name space within this one; one that begins with a slash stands alone."""
        if namespace.startswith("/"):
            return namespace.rstrip("/")
        return f"{self.namespace}/{namespace.rstrip('/')}" if namespace else self.namespace


def with_changes(env: Mapping[str, str], changes: Mapping[str, str | None]) -> dict[str, str]:
    """Return environment variables with changes; None takes one away."""
    return {name: value for name, value in {**env, **changes}.items() if value is not None}


class _Element(LaunchContext):
    """An element where it stands: its attributes, with their substitutions made, and errors with its line."""

    def __init__(self, element: Element, scope: _Scope, file: Path):
        super().__init__(file, element.line, scope.variables, with_changes(os.environ, scope.env))
        self.tag, self.attributes, self.children = element.tag, element.attributes, element.children
        self.scope = scope

    def inner(self) -> Iterator[_Element]:
        """Yield what stands in it."""
        return (_Element(child, self.scope, self.source) for child in self.children)

    def of(self, tag: str) -> Iterator[_Element]:
        """Yield the children of one tag."""
        return (child for child in self.inner() if child.tag == tag)

    def check(self, allowed: set[str]) -> None:
        """Refuse attributes that aren't understood, of the element and of those that stand in it."""
        inner = _INNER.get(self.tag, {})
        for name in self.attributes:
            if name not in allowed:
                inside = f"; inside of it: {listing(f'<{tag}>' for tag in inner)}" if inner else ""
                supported = f"{nearest(name, allowed)} (supported: {listing(sorted(allowed))}{inside})"
                raise self.error(f"<{self.tag}>: the attribute {name!r} is not supported{supported}")
        if self.tag in _OF_ELEMENTS:
            return
        for child in self.inner():
            if child.tag not in inner:
                instead = f"{nearest(child.tag, inner)} (available: {listing(sorted(inner))})"
                raise child.error(f"<{child.tag}> can't stand in <{self.tag}> here{instead}")
            child.check(inner[child.tag])

    def holds(self) -> bool:
        """Tell whether its conditions hold."""
        if_, unless = self.attributes.get("if"), self.attributes.get("unless")
        holds = if_ is None or truth(if_, self, "`if`")
        return holds and (unless is None or not truth(unless, self, "`unless`"))

    def text(self, name: str, default: str | None = None) -> str:
        """Return an attribute with its substitutions made."""
        if name in self.attributes:
            return substitute(self.attributes[name], self)
        if default is None:
            raise self.error(f"<{self.tag}> needs the attribute {name!r}")
        return default

    def flag(self, name: str, default: str | None = None) -> bool:
        """Return the truth value of an attribute."""
        return truth(self.text(name, default), self, f"`{name}`")

    def words(self, name: str, default: str | None = None) -> list[str]:
        """Return the words of an attribute, as a shell splits them."""
        said = self.text(name, default)
        try:
            return shlex.split(said)
        except ValueError:
            raise self.error(f"{name}: a quotation mark is missing in {said!r}") from None

    def file(self, name: str) -> str:
        """Return an attribute that is the path of a file."""
        if not Path(file := self.text(name)).is_file():
            raise self.error(f"<{self.tag} {name}=...>: there is no file {file}")
        return file

    def seconds(self, name: str, default: str | None = None) -> float:
        """Return an attribute that is a time [s]."""
        said = self.text(name, default)
        try:
            value = float(said)
        except ValueError:
            value = -1.0
        if not 0 <= value < math.inf:
            raise self.error(f"{name} is a number of seconds, not {said!r}")
        return value


class _Reader:
    def __init__(self, env: Mapping[str, str]):
        self.processes: list[Member] = []
        self._env = env
        self._names: dict[str, int] = {}
        self._files: tuple[Path, ...] = ()
        self._given: dict[str, str] = {}

    def read_file(self, path: Path, given: dict[str, str], scope: _Scope, above: tuple[Path, ...]) -> None:
        if len(above) >= DEEPEST:
            raise LaunchError(str(path), None, f"files include each other more than {DEEPEST} deep")
        root = read_elements(path)
        files, outer, self._files, self._given = self._files, self._given, (*above, path), given
        scope.variables.update(given)
        declared = {e.attributes.get("name", "") for e in root.of("arg")}
        unknown = sorted(set(given) - declared) if not above else []
        if unknown:
            hint = nearest(unknown[0], declared)
            known = listing(sorted(declared))
            raise LaunchError(str(path), None, f"no argument {unknown[0]!r}{hint} (available: {known})")
        self._all(root.children, scope)
        self._files, self._given = files, outer

    def _all(self, elements: Sequence[Element], scope: _Scope) -> None:
        for element in elements:
            at = _Element(element, scope, self._files[-1])
            handler = _HANDLERS.get(element.tag)
            if handler is None:
                homes = [f"<{outer}>" for outer, inner in _INNER.items() if element.tag in inner]
                instead = f"; it stands in {' or '.join(homes)}" if homes else nearest(element.tag, _HANDLERS)
                raise at.error(
                    f"<{element.tag}> is not supported{instead} (supported: {listing(sorted(_HANDLERS))}); "
                    "with ROS's own tools on the path, files are run by `ros2 launch`"
                )
            at.check(handler[1] | _CONDITIONS)
            if at.holds():
                handler[0](self, at)

    # --- elements ---

    def _arg(self, at: _Element) -> None:
        name = at.text("name")
        if "value" in at.attributes and "default" not in at.attributes:
            raise at.error("<arg value=...> is ROS 1 syntax; a constant is <let name= value=>")
        default = at.text("default") if "default" in at.attributes else None
        choices = tuple(c.text("value") for c in at.of("choice"))
        if name not in self._given and name not in at.scope.variables:
            if default is None:
                doc = at.attributes.get("description", "")
                raise at.error(f"the argument {name!r} is needed{f' ({doc})' if doc else ''}: {name}:=VALUE")
            at.scope.variables[name] = default
        if choices and at.scope.variables[name] not in choices:
            said = at.scope.variables[name]
            raise at.error(f"{name}:={said}: not one of {', '.join(choices)}")

    def _let(self, at: _Element) -> None:
        at.scope.variables[at.text("name")] = at.text("value")

    def _environment(self, at: _Element) -> None:
        name, value = at.text("name"), None if at.tag == "unset_env" else at.text("value")
        if at.tag == "append_env" and value is not None and name in at.env:
            words = [value, at.env[name]] if at.flag("prepend", "false") else [at.env[name], value]
            value = at.text("separator", os.pathsep).join(words)
        at.scope.env[name] = value

    def _timer(self, at: _Element) -> None:
        inner = at.scope.copy()
        inner.after += at.seconds("period")
        self._all(at.children, inner)

    def _log(self, at: _Element) -> None:
        """Pass over what is only said."""

    def _shutdown(self, at: _Element) -> None:
        """Have a process that does nothing, and with which all end, started in its time."""
        at.attributes = {"on_exit": "shutdown"}
        self._start(at, ["true"], "shutdown")

    def _namespace(self, at: _Element) -> None:
        at.scope.namespace = at.scope.within(at.text("namespace"))

    def _for_nodes(self, at: _Element) -> None:
        match at.tag:
            case "set_remap":
                words = ("-r", f"{at.text('from')}:={at.text('to')}")
            case "set_parameter":
                words = ("-p", f"{at.text('name')}:={at.text('value')}")
            case "set_use_sim_time":
                words = ("-p", f"use_sim_time:={str(at.flag('value')).lower()}")
            case _:
                words = ("--params-file", at.file("filename"))
        at.scope.ros_args += words

    def _group(self, at: _Element) -> None:
        scoped = at.flag("scoped", "true")
        self._all(at.children, at.scope.copy() if scoped else at.scope)

    def _include(self, at: _Element) -> None:
        file = Path(at.text("file"))
        if not file.is_absolute():
            file = self._files[-1].parent / file
        if not file.is_file():
            there = sorted(f.name for f in file.parent.glob("*launch*"))
            reason = f"<include>: there is no file {file}{nearest(file.name, there)}"
            raise at.error(f"{reason} (launch files there: {listing(there)})")
        given = {a.text("name"): a.text("value") for a in (*at.of("arg"), *at.of("let"))}
        try:
            self.read_file(file, given, at.scope, self._files)  # its settings reach what follows, as in ROS itself
        except LaunchError as error:
            if error.source == str(file) and error.line is None:
                raise at.error(f"<include>: {error}") from None
            raise

    def _node(self, at: _Element) -> None:
        package, program = at.text("pkg"), at.text("exec")
        try:
            file = str(executable_of(package, program))
        except PackageError as error:
            raise at.error(str(error)) from None
        name, namespace = at.text("name", ""), at.scope.within(at.text("namespace", ""))
        own = [
            word for own, said in (("__node", name), ("__ns", namespace)) if said for word in ("-r", f"{own}:={said}")
        ]
        ros = [*own, *at.scope.ros_args]
        for remap in at.of("remap"):
            ros += ["-r", f"{remap.text('from')}:={remap.text('to')}"]
        for parameter in at.of("param"):
            ros += self._parameters(parameter)
        ros += at.words("ros_args", "")
        command = [file, *at.words("args", ""), *(["--ros-args", *ros] if ros else [])]
        self._start(at, command, name or program)

    def _parameters(self, at: _Element) -> list[str]:
        """Return the arguments behind `--ros-args` for one `<param>`: a value, nested ones, or a file."""
        if "from" not in at.attributes:
            return [word for pair in self._values(at, "") for word in ("-p", pair)]
        if at.flag("allow_substs", "false"):
            reason = "substitutions in a file of parameters aren't made here; give those as <param name= value=>"
            raise at.error(f"<param from=... allow_substs=...>: {reason}")
        return ["--params-file", at.file("from")]

    def _values(self, at: _Element, above: str) -> Iterator[str]:
        name = above + at.text("name")
        if at.children:
            for child in at.inner():
                yield from self._values(child, f"{name}.")
            return
        value, type_ = at.text("value"), at.text("type", "yaml")
        if type_ not in ("int", "float", "bool", "str", "yaml"):
            raise at.error(f"<param type={type_!r}> is not supported (supported: int, float, bool, str, yaml)")
        if "value-sep" in at.attributes:
            value = f"[{', '.join(item.strip() for item in value.split(at.text('value-sep')))}]"
        elif type_ == "str" or not value:
            value = "'" + value.replace("'", "''") + "'"
        yield f"{name}:={value}"

    def _executable(self, at: _Element) -> None:
        words = at.words("cmd")
        if not words:
            raise at.error("<executable>: `cmd` is empty")
        if at.flag("shell", "false"):
            words = ["/bin/sh", "-c", at.text("cmd")]
        self._start(at, words, at.text("name", Path(words[0]).stem))

    def _start(self, at: _Element, command: list[str], name: str) -> None:
        prefix = at.words("launch-prefix", "")
        env = at.scope.env | {e.text("name"): e.text("value") for e in at.of("env")}
        on_exit = at.text("on_exit", "")
        if on_exit not in ("", "shutdown"):
            raise at.error(f"on_exit={on_exit!r} is not supported (supported: shutdown)")
        folder = at.text("cwd", "")
        count = self._names[name] = self._names.get(name, 0) + 1
        most = at.text("respawn_max_retries", "-1")
        if not most.lstrip("-").isdigit():
            raise at.error(f"respawn_max_retries is a whole number, -1 for no end, not {most!r}")
        respawn = at.flag("respawn", "false")
        self.processes.append(
            Member(
                name if count == 1 else f"{name}-{count}",
                tuple([*prefix, *command]),
                Path(folder) if folder else Path.cwd(),
                with_changes(self._env, env),
                restart="always" if respawn else "never",
                restarts=0 if not respawn else int(most) if int(most) >= 0 else sys.maxsize,
                restart_delay=at.seconds("respawn_delay", "0"),
                required=False,
                ends_all=on_exit == "shutdown",
                after=at.scope.after,
            )
        )


_COMMON = {"name", "output", "respawn", "respawn_delay", "respawn_max_retries", "launch-prefix", "on_exit", "cwd"}
_COMMON |= {"emulate_tty"}  # where what is printed looks the same: it goes into a file
_LOG = {"message", "level"}
_OF_ELEMENTS = {"group", "timer"}
_NAMED = {"name", "value"}
_HANDLERS: dict[str, tuple[Callable[[_Reader, _Element], None], set[str]]] = {
    "arg": (_Reader._arg, {"name", "default", "description", "value"}),
    "let": (_Reader._let, _NAMED),
    "set_env": (_Reader._environment, _NAMED),
    "unset_env": (_Reader._environment, {"name"}),
    "push_ros_namespace": (_Reader._namespace, {"namespace"}),
    "push-ros-namespace": (_Reader._namespace, {"namespace"}),
    "append_env": (_Reader._environment, _NAMED | {"prepend", "separator"}),
    "timer": (_Reader._timer, {"period"}),
    "log": (_Reader._log, _LOG),
    **{f"log_{level}": (_Reader._log, {"message"}) for level in ("debug", "info", "warning", "error")},
    "shutdown": (_Reader._shutdown, {"reason"}),
    "set_remap": (_Reader._for_nodes, {"from", "to"}),
    "set_parameter": (_Reader._for_nodes, _NAMED),
    "set_parameters_from_file": (_Reader._for_nodes, {"filename"}),
    "set_use_sim_time": (_Reader._for_nodes, {"value"}),
    "group": (_Reader._group, {"scoped"}),
    "include": (_Reader._include, {"file"}),
    "node": (_Reader._node, _COMMON | {"pkg", "exec", "namespace", "args", "ros_args"}),
    "executable": (_Reader._executable, _COMMON | {"cmd", "shell"}),
}
_PARAM = _NAMED | {"type", "value-sep", "from", "allow_substs"}
_INNER: dict[str, dict[str, set[str]]] = {
    "arg": {"choice": {"value"}},
    "include": {"arg": _NAMED, "let": _NAMED},
    "node": {"param": _PARAM, "remap": {"from", "to"}, "env": _NAMED},
    "param": {"param": _PARAM},
    "executable": {"env": _NAMED},
}
"""What can stand in an element, with its attributes."""
