"""From a launch file to the processes that it asks for; arguments, conditions, groups and includes resolved."""

from __future__ import annotations

import math
import os
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from grip_bt.base.errors import listing, nearest

from ..interfaces.ament import PackageError, executable_of
from .element import Element, LaunchError, check_not_legacy, read_elements
from .hints import TYPES, about_attributes, about_tag, form
from .model import Argument, Launch, LaunchedProcess, LaunchEvent, Scope, joined
from .python_draft import in_python
from .substitutions import Place, substitute, truth

DEEPEST = 30
"""Files that include each other."""
_CONDITIONS = {"if", "unless"}


def read_launch_file(
    path: Path | str, arguments: Mapping[str, str] | None = None, prefixes: Sequence[Path] | None = None
) -> Launch:
    """Read an XML or YAML launch file and return the processes that it asks for.

    Args:
        path: the file.
        arguments: values of its arguments.
        prefixes: where packages are; the usual places by default.

    Raises:
        LaunchError: it is wrong, asks for something that isn't here, or uses what isn't understood; by name and line.
        LegacyLaunchFileError: it is one of ROS 1; it says what to change.
    """
    reader = _Reader(prefixes)
    reader.read_file(Path(path), dict(arguments or {}), Scope({}, {}), ())
    return reader.launch


def read_arguments(path: Path) -> list[Argument]:
    """Return the arguments that an XML or YAML launch file itself declares, with their defaults as they are written.

    Raises:
        LaunchError: it can't be read, or is one of ROS 1.
    """
    if path.suffix == ".py":
        raise in_python(path)
    root = read_elements(path)
    check_not_legacy(root, path)
    return [
        Argument(
            element.attributes.get("name", ""),
            element.attributes.get("default"),
            element.attributes.get("description", ""),
            tuple(choice.attributes.get("value", "") for choice in element.of("choice")),
        )
        for element in root.of("arg")
    ]


class _Reader:
    def __init__(self, prefixes: Sequence[Path] | None):
        self.launch = Launch()
        self._prefixes = prefixes
        self._names: dict[str, int] = {}
        self._files: tuple[Path, ...] = ()
        self._given: dict[str, str] = {}

    def read_file(self, path: Path, given: dict[str, str], scope: Scope, above: tuple[Path, ...]) -> None:
        if len(above) >= DEEPEST:
            raise LaunchError(str(path), None, f"files include each other more than {DEEPEST} deep")
        if path.suffix == ".py":
            raise in_python(path)
        root = read_elements(path)
        check_not_legacy(root, path)
        files, outer, self._files, self._given = self._files, self._given, (*above, path), given
        scope.variables.update(given)
        declared = {e.attributes.get("name", "") for e in root.of("arg")}
        unknown = sorted(set(given) - declared) if not above else []
        if unknown:
            hint = nearest(unknown[0], declared)
            known = listing(sorted(declared))
            raise LaunchError(str(path), None, f"no argument {unknown[0]!r}{hint} (there are: {known})")
        self._all(root.children, scope)
        self._files, self._given = files, outer

    def _all(self, elements: Sequence[Element], scope: Scope) -> None:
        for element in elements:
            handler = _HANDLERS.get(element.tag)
            if handler is None:
                if element.tag in _COMPOSED:
                    raise self._place(element, scope).error(f"<{element.tag}> isn't understood here: {_CONTAINERS}")
                known = listing(sorted(_HANDLERS))
                instead = about_tag(element.tag, "launch", _HANDLERS, self._in_yaml)
                reason = f"<{element.tag}> isn't understood here{instead} (what is: {known})"
                raise self._place(element, scope).error(
                    f"{reason}; with ROS's own tools on the path, files are run by `ros2 launch`"
                )
            if self._holds(element, scope):
                handler[0](self, element, scope)

    def _place(self, element: Element, scope: Scope) -> Place:
        return Place(self._files[-1], element.line, scope.variables, {**os.environ, **scope.env}, self._prefixes)

    def _holds(self, element: Element, scope: Scope) -> bool:
        """Tell whether the element's conditions hold, after a look at its attributes."""
        self._check(element, scope, _HANDLERS[element.tag][1] | _CONDITIONS)
        place = self._place(element, scope)
        if_, unless = element.attributes.get("if"), element.attributes.get("unless")
        holds = if_ is None or truth(if_, place, "`if`")
        return holds and (unless is None or not truth(unless, place, "`unless`"))

    def _check(self, element: Element, scope: Scope, allowed: set[str]) -> None:
        """Refuse attributes that aren't understood, of the element and of those that stand in it."""
        place = self._place(element, scope)
        wrong = [name for name in element.attributes if name not in allowed]
        if wrong:
            raise place.error(f"<{element.tag}>: {about_attributes(element.tag, wrong, allowed, self._in_yaml)}")
        if element.tag in _OF_ELEMENTS:
            return
        inner = _INNER.get(element.tag, {})
        for child in element.children:
            if child.tag not in inner:
                instead = about_tag(child.tag, element.tag, inner, self._in_yaml)
                raise self._place(child, scope).error(f"<{child.tag}> can't stand in <{element.tag}> here{instead}")
            self._check(child, scope, inner[child.tag])

    @property
    def _in_yaml(self) -> bool:
        return self._files[-1].suffix in (".yaml", ".yml")

    def _text(self, element: Element, scope: Scope, name: str, default: str | None = None) -> str:
        """Return an attribute with its substitutions made."""
        if name not in element.attributes:
            if default is None:
                how = form(element.tag, self._in_yaml, given=element.tag == "arg" and name == "value")
                like = f", such as {how}" if how else ""
                raise self._place(element, scope).error(f"<{element.tag}> needs the attribute {name!r}{like}")
            return default
        return substitute(element.attributes[name], self._place(element, scope))

    def _flag(self, element: Element, scope: Scope, name: str, default: str | None = None) -> bool:
        """Return the truth value of an attribute."""
        return truth(self._text(element, scope, name, default), self._place(element, scope), f"`{name}`")

    def _words(self, element: Element, scope: Scope, name: str, default: str | None = None) -> list[str]:
        """Return the words of an attribute, as a shell splits them."""
        said = self._text(element, scope, name, default)
        try:
            return shlex.split(said)
        except ValueError:
            raise self._place(element, scope).error(f"{name}: a quotation mark is missing in {said!r}") from None

    def _one_of(self, element: Element, scope: Scope, name: str, default: str, allowed: Sequence[str]) -> str:
        """Return an attribute that has one of a few values."""
        said = self._text(element, scope, name, default)
        if said.lower() not in allowed:
            reason = f"{name} is one of {listing(allowed)}, not {said!r}{nearest(said, allowed)}"
            raise self._place(element, scope).error(reason)
        return said.lower()

    # --- elements ---

    def _arg(self, element: Element, scope: Scope) -> None:
        name = self._text(element, scope, "name")
        if "value" in element.attributes and "default" not in element.attributes:
            raise self._place(element, scope).error(
                "<arg value=...> is of ROS 1 here; a constant is <let name= value=>"
            )
        default = self._text(element, scope, "default") if "default" in element.attributes else None
        choices = tuple(self._text(c, scope, "value") for c in element.of("choice"))
        if len(self._files) == 1:
            self.launch.arguments.append(Argument(name, default, element.attributes.get("description", ""), choices))
        if name not in self._given and name not in scope.variables:
            if default is None:
                doc = element.attributes.get("description", "")
                raise self._place(element, scope).error(
                    f"the argument {name!r} is needed{f' ({doc})' if doc else ''}: {name}:=VALUE"
                )
            scope.variables[name] = default
        if choices and scope.variables[name] not in choices:
            said = scope.variables[name]
            raise self._place(element, scope).error(f"{name}:={said}: not one of {', '.join(choices)}")

    def _let(self, element: Element, scope: Scope) -> None:
        scope.variables[self._text(element, scope, "name")] = self._text(element, scope, "value")

    def _set_env(self, element: Element, scope: Scope) -> None:
        name = self._text(element, scope, "name")
        scope.env[name] = self._text(element, scope, "value")
        scope.unset -= {name}

    def _unset_env(self, element: Element, scope: Scope) -> None:
        name = self._text(element, scope, "name")
        scope.env.pop(name, None)
        scope.unset |= {name}

    def _append_env(self, element: Element, scope: Scope) -> None:
        name, value = self._text(element, scope, "name"), self._text(element, scope, "value")
        place = self._place(element, scope)
        present = None if name in scope.unset else place.env.get(name)
        if present is not None:
            first = self._flag(element, scope, "prepend", "false")
            value = self._text(element, scope, "separator", os.pathsep).join(
                (value, present) if first else (present, value)
            )
        scope.env[name] = value
        scope.unset -= {name}

    def _timer(self, element: Element, scope: Scope) -> None:
        period = self._seconds(element, scope, "period")
        inner = scope.copy()
        inner.after += period
        self._all(element.children, inner)

    def _log(self, element: Element, scope: Scope) -> None:
        said = self._text(element, scope, "message")
        level = self._one_of(element, scope, "level", element.tag.removeprefix("log").strip("_") or "info", _LEVELS)
        self.launch.events.append(LaunchEvent(said if level == "info" else f"{level}: {said}", scope.after))

    def _shutdown(self, element: Element, scope: Scope) -> None:
        reason = self._text(element, scope, "reason", "the launch file ends everything")
        self.launch.events.append(LaunchEvent(reason, scope.after, ends=True))

    def _seconds(self, element: Element, scope: Scope, name: str, default: str | None = None) -> float:
        said = self._text(element, scope, name, default)
        try:
            value = float(said)
        except ValueError:
            value = -1.0
        if not 0 <= value < math.inf:
            raise self._place(element, scope).error(f"{name} is a number of seconds, not {said!r}")
        return value

    def _namespace(self, element: Element, scope: Scope) -> None:
        scope.namespace = joined(scope.namespace, self._text(element, scope, "namespace"))

    def _set_remap(self, element: Element, scope: Scope) -> None:
        scope.remaps = (*scope.remaps, (self._text(element, scope, "from"), self._text(element, scope, "to")))

    def _set_parameter(self, element: Element, scope: Scope) -> None:
        name, value = self._text(element, scope, "name"), self._text(element, scope, "value")
        scope.parameters = (*scope.parameters, "-p", f"{name}:={value}")

    def _set_parameters_from_file(self, element: Element, scope: Scope) -> None:
        file = Path(self._text(element, scope, "filename"))
        if not file.is_file():
            raise self._place(element, scope).error(f"<set_parameters_from_file>: there is no file {file}")
        scope.parameters = (*scope.parameters, "--params-file", str(file))

    def _set_use_sim_time(self, element: Element, scope: Scope) -> None:
        value = self._flag(element, scope, "value")
        scope.parameters = (*scope.parameters, "-p", f"use_sim_time:={str(value).lower()}")

    def _group(self, element: Element, scope: Scope) -> None:
        scoped = self._flag(element, scope, "scoped", "true")
        self._all(element.children, scope.copy() if scoped else scope)

    def _include(self, element: Element, scope: Scope) -> None:
        file = Path(self._text(element, scope, "file"))
        if not file.is_absolute():
            file = self._files[-1].parent / file
        if not file.is_file():
            there = sorted(f.name for f in file.parent.glob("*") if ".launch" in f.name or f.suffix in _LAUNCH_FILES)
            reason = f"<include>: there is no file {file}{nearest(file.name, there)}"
            raise self._place(element, scope).error(f"{reason} (launch files there: {listing(there)})")
        inner = [*element.of("arg"), *element.of("let")]
        given = {self._text(a, scope, "name"): self._text(a, scope, "value") for a in inner}
        try:
            self.read_file(file, given, scope, self._files)  # its settings reach what follows, as in ROS itself
        except LaunchError as error:
            if error.source == str(file) and error.line is None:
                raise self._place(element, scope).error(f"<include>: {error}") from None
            raise

    def _node(self, element: Element, scope: Scope) -> None:
        place = self._place(element, scope)
        package, program = self._text(element, scope, "pkg"), self._text(element, scope, "exec")
        try:
            file = str(executable_of(package, program, self._prefixes))
        except PackageError as error:
            raise place.error(str(error)) from None
        name = self._text(element, scope, "name", "")
        own = self._text(element, scope, "namespace", "")
        namespace = joined(scope.namespace, own) if own else scope.namespace
        remaps = [
            *scope.remaps,
            *((self._text(r, scope, "from"), self._text(r, scope, "to")) for r in element.of("remap")),
        ]
        ros = [*(["-r", f"__node:={name}"] if name else []), *(["-r", f"__ns:={namespace}"] if namespace else [])]
        for source, target in remaps:
            ros += ["-r", f"{source}:={target}"]
        ros += scope.parameters
        for parameter in element.of("param"):
            ros += self._parameters(parameter, scope)
        ros += self._words(element, scope, "ros_args", "")
        words = self._words(element, scope, "args", "")
        command = [file, *words, *(["--ros-args", *ros] if ros else [])]
        self._start(element, scope, command, name or program)

    def _parameters(self, element: Element, scope: Scope) -> list[str]:
        """Return the arguments behind `--ros-args` for one `<param>`: a value, nested ones, or a file."""
        place = self._place(element, scope)
        if "from" not in element.attributes:
            return [word for pair in self._values(element, scope, "") for word in ("-p", pair)]
        file = Path(self._text(element, scope, "from"))
        if not file.is_file():
            raise place.error(f"<param from=...>: there is no file {file}")
        if self._flag(element, scope, "allow_substs", "false"):
            reason = "substitutions in a file of parameters aren't made here; give those as <param name= value=>"
            raise place.error(f"<param from=... allow_substs=...>: {reason}")
        return ["--params-file", str(file)]

    def _values(self, element: Element, scope: Scope, above: str) -> Iterator[str]:
        name = above + self._text(element, scope, "name")
        if element.children:
            for child in element.children:
                if child.tag != "param":
                    raise self._place(element, scope).error(f"<{child.tag}> can't stand in <param>")
                yield from self._values(child, scope, f"{name}.")
        elif "value-sep" in element.attributes:
            items = self._text(element, scope, "value").split(self._text(element, scope, "value-sep"))
            yield f"{name}:=[{', '.join(item.strip() for item in items)}]"
        else:
            yield f"{name}:={self._typed(element, scope)}"

    def _typed(self, element: Element, scope: Scope) -> str:
        value, type_ = self._text(element, scope, "value"), self._text(element, scope, "type", "")
        if type_ in ("", "int", "float", "bool", "yaml"):
            return value if value else "''"
        if type_ == "str":
            return "'" + value.replace("'", "''") + "'"
        meant = f"; write {TYPES[type_]!r}" if type_ in TYPES else ""
        reason = f"<param type={type_!r}> isn't understood here{meant} (what is: int, float, bool, str, yaml)"
        raise self._place(element, scope).error(reason)

    def _executable(self, element: Element, scope: Scope) -> None:
        words = self._words(element, scope, "cmd")
        if not words:
            raise self._place(element, scope).error("<executable>: `cmd` is empty")
        if self._flag(element, scope, "shell", "false"):
            words = ["/bin/sh", "-c", self._text(element, scope, "cmd")]
        self._start(element, scope, words, self._text(element, scope, "name", Path(words[0]).stem))

    def _start(self, element: Element, scope: Scope, command: list[str], name: str) -> None:
        place = self._place(element, scope)
        prefix = self._words(element, scope, "launch-prefix", "")
        env = {**scope.env, **{self._text(e, scope, "name"): self._text(e, scope, "value") for e in element.of("env")}}
        on_exit = self._text(element, scope, "on_exit", "")
        if on_exit not in ("", "shutdown"):
            raise place.error(f'on_exit={on_exit!r} isn\'t understood here; only "shutdown" is')
        self._one_of(element, scope, "output", "log", _OUTPUTS)
        folder = self._text(element, scope, "cwd", "")
        count = self._names[name] = self._names.get(name, 0) + 1
        most = self._text(element, scope, "respawn_max_retries", "-1")
        if not most.lstrip("-").isdigit():
            raise place.error(f"respawn_max_retries is a whole number, -1 for no end, not {most!r}")
        self.launch.processes.append(
            LaunchedProcess(
                name if count == 1 else f"{name}-{count}",
                tuple([*prefix, *command]),
                env,
                scope.unset,
                Path(folder) if folder else None,
                self._flag(element, scope, "respawn", "false"),
                self._seconds(element, scope, "respawn_delay", "0"),
                on_exit == "shutdown",
                f"{self._files[-1]}:{element.line}",
                int(most) if int(most) >= 0 else None,
                scope.after,
            )
        )


_COMMON = {"name", "output", "respawn", "respawn_delay", "respawn_max_retries", "launch-prefix", "on_exit", "cwd"}
_COMMON |= {"emulate_tty"}  # where what is printed looks the same: it goes into a file
_LOG = {"message", "level"}
_LEVELS = ("debug", "info", "warning", "warn", "error", "critical")
_OUTPUTS = ("screen", "log", "both", "own_log", "full")
_LAUNCH_FILES = (".xml", ".yaml", ".yml")
_OF_ELEMENTS = {"group", "timer"}
_COMPOSED = {"node_container", "load_composable_node", "composable_node"}
_CONTAINERS = (
    "its nodes are libraries, which the container of rclcpp_components loads into one process; a ROS that "
    "has it runs the file itself (`ros2 launch`). Most packages have the same nodes as programs, for <node pkg= exec=>"
)
_NAMED = {"name", "value"}
_HANDLERS: dict[str, tuple[Callable[[_Reader, Element, Scope], None], set[str]]] = {
    "arg": (_Reader._arg, {"name", "default", "description", "value"}),
    "let": (_Reader._let, _NAMED),
    "set_env": (_Reader._set_env, _NAMED),
    "unset_env": (_Reader._unset_env, {"name"}),
    "push_ros_namespace": (_Reader._namespace, {"namespace"}),
    "push-ros-namespace": (_Reader._namespace, {"namespace"}),
    "append_env": (_Reader._append_env, _NAMED | {"prepend", "separator"}),
    "timer": (_Reader._timer, {"period"}),
    "log": (_Reader._log, _LOG),
    **{f"log_{level}": (_Reader._log, {"message"}) for level in ("debug", "info", "warning", "error")},
    "shutdown": (_Reader._shutdown, {"reason"}),
    "set_remap": (_Reader._set_remap, {"from", "to"}),
    "set_parameter": (_Reader._set_parameter, _NAMED),
    "set_parameters_from_file": (_Reader._set_parameters_from_file, {"filename"}),
    "set_use_sim_time": (_Reader._set_use_sim_time, {"value"}),
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
