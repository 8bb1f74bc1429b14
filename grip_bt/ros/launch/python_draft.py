"""A Python launch file said in XML, as far as it can be read without running it: a draft for whoever rewrites it.

Calls of `Node`, `ExecuteProcess`, `DeclareLaunchArgument`, `IncludeLaunchDescription` and the like are found anywhere
in the file. What isn't a literal or one of the usual substitutions becomes `...`; what has no counterpart, a comment.
"""

from __future__ import annotations

import ast
import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .element import LaunchError

UNKNOWN = "..."
"""What stands for something that isn't known before the file runs."""
_BY_HAND = {
    "GroupAction": "what is in it belongs into a <group>",
    "PushRosNamespace": 'as the first element of its <group>: <push_ros_namespace namespace="..."/>',
    "SetParameter": '<set_parameter name="..." value="..."/>',
    "SetRemap": '<set_remap from="..." to="..."/>',
    "SetEnvironmentVariable": '<set_env name="..." value="..."/>',
    "TimerAction": 'what is in it belongs into a <timer period="...">',
    "RegisterEventHandler": "nothing here waits for events; a project's processes wait for each other (`ready`)",
    "OpaqueFunction": "a function that runs while the file is read; nothing here does",
    "ComposableNodeContainer": "libraries for rclcpp_components; take the same nodes as programs, by <node>",
    "LoadComposableNodes": "libraries for rclcpp_components; take the same nodes as programs, by <node>",
}
"""What is said of calls that a draft can't turn."""
_SOURCES = re.compile(r"\w*LaunchDescriptionSource$")


_REASON = (
    "a launch file in Python is a program of ROS's own `launch` package, which isn't here; "
    "source a ROS that has it (source /opt/ros/jazzy/setup.bash), or say the same in XML or YAML"
)


def in_python(path: Path) -> LaunchError:
    """Return the error of a Python launch file, with what would be written instead."""
    if not path.is_file():
        return LaunchError(str(path), None, "there is no such file")
    try:
        draft = draft_of(path)
    except (OSError, SyntaxError, ValueError, RecursionError) as error:
        line = error.lineno if isinstance(error, SyntaxError) else None
        return LaunchError(str(path), line, f"{_REASON} (this one can't be read: {error})")
    if not draft:
        return LaunchError(str(path), None, _REASON)
    name = path.name.removesuffix(".py") + ".xml"
    return LaunchError(str(path), None, f"{_REASON}. A draft of {name}, read without running it:\n{draft}")


def draft_of(path: Path) -> str:
    """Return an XML launch file with what a Python one declares and starts; empty where nothing of it is found.

    Raises:
        OSError: the file can't be read.
        SyntaxError, ValueError: it isn't Python.
    """
    tree = ast.parse(path.read_text(encoding="utf-8"))
    reader = _Reader(_assigned(tree))
    root = ET.Element("launch")
    found = [element for call in _calls(tree) if (element := reader.element(call)) is not None]
    root.extend(sorted(found, key=lambda element: element.tag != "arg"))  # before what reads them
    if not len(root):
        return ""
    ET.indent(root)
    return ET.tostring(root, encoding="unicode")


def _calls(tree: ast.AST) -> list[ast.Call]:
    found = [node for node in ast.walk(tree) if isinstance(node, ast.Call)]
    return sorted(found, key=lambda call: (call.lineno, call.col_offset))


def _assigned(tree: ast.AST) -> dict[str, ast.expr]:
    values: dict[str, list[ast.expr]] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            for target in node.targets:
                for name in (n.id for n in ast.walk(target) if isinstance(n, ast.Name)):
                    values.setdefault(name, []).append(node.value)
    return {name: found[0] for name, found in values.items() if len(found) == 1}


class _Reader:
    def __init__(self, assigned: Mapping[str, ast.expr]):
        self._assigned = assigned

    def element(self, call: ast.Call) -> ET.Element[Any] | None:
        """Return what a call becomes; None for calls that start and declare nothing."""
        name, given = _name(call), {k.arg: k.value for k in call.keywords if k.arg is not None}
        if name in ("Node", "LifecycleNode"):
            return self._node(given)
        if name == "ExecuteProcess":
            return self._with_condition(ET.Element("executable", cmd=self._words(given.get("cmd"))), given)
        if name == "DeclareLaunchArgument":
            return self._argument(call, given)
        if name == "IncludeLaunchDescription":
            return self._include(call, given)
        if name in _BY_HAND:
            return ET.Comment(f" line {call.lineno}: {name}: {_BY_HAND[name]} ")
        return None

    def _node(self, given: Mapping[str, ast.expr]) -> ET.Element:
        node = ET.Element("node", pkg=self._of(given, "package"), exec=self._of(given, "executable"))
        for key in ("name", "namespace"):
            if key in given:
                node.set(key, self.text(given[key]))
        if "arguments" in given:
            node.set("args", self._words(given["arguments"]))
        for part in self._list(given.get("parameters")):
            node.extend(self._parameters(part))
        for pair in self._list(given.get("remappings")):
            source, target = pair.elts if isinstance(pair, ast.Tuple) and len(pair.elts) == 2 else (pair, pair)
            ET.SubElement(node, "remap", {"from": self.text(source), "to": self.text(target)})
        return self._with_condition(node, given)

    def _parameters(self, part: ast.expr) -> list[ET.Element]:
        part = self._value(part)
        if not isinstance(part, ast.Dict):
            return [ET.Element("param", {"from": self.text(part)})]
        pairs = [(key, value) for key, value in zip(part.keys, part.values, strict=True) if key is not None]
        return [ET.Element("param", name=self.text(key), value=self.text(value)) for key, value in pairs]

    def _argument(self, call: ast.Call, given: Mapping[str, ast.expr]) -> ET.Element:
        element = ET.Element("arg", name=self.text(call.args[0]) if call.args else self._of(given, "name"))
        for key, attribute in (("default_value", "default"), ("description", "description")):
            if key in given:
                element.set(attribute, self.text(given[key]))
        for choice in self._list(given.get("choices")):
            ET.SubElement(element, "choice", value=self.text(choice))
        return element

    def _include(self, call: ast.Call, given: Mapping[str, ast.expr]) -> ET.Element:
        source = self._value(call.args[0]) if call.args else None
        if isinstance(source, ast.Call) and _SOURCES.match(_name(source)) and source.args:
            source = source.args[0]
        element = ET.Element("include", file=UNKNOWN if source is None else self.text(source))
        arguments = given.get("launch_arguments")
        if isinstance(arguments, ast.Call) and isinstance(arguments.func, ast.Attribute):
            arguments = arguments.func.value  # {...}.items()
        value = None if arguments is None else self._value(arguments)
        pairs = [*zip(value.keys, value.values, strict=True)] if isinstance(value, ast.Dict) else []
        for pair in self._list(value):
            if isinstance(pair, ast.Tuple) and len(pair.elts) == 2:
                pairs.append((pair.elts[0], pair.elts[1]))
        for key, item in pairs:
            if key is not None:
                ET.SubElement(element, "arg", name=self.text(key), value=self.text(item))
        return self._with_condition(element, given)

    def _with_condition(self, element: ET.Element, given: Mapping[str, ast.expr]) -> ET.Element:
        condition = self._value(given["condition"]) if "condition" in given else None
        if isinstance(condition, ast.Call):
            key = {"IfCondition": "if", "UnlessCondition": "unless"}.get(_name(condition))
            if key is not None and condition.args:
                element.set(key, self.text(condition.args[0]))
        return element

    def _of(self, given: Mapping[str, ast.expr], key: str) -> str:
        return self.text(given[key]) if key in given else UNKNOWN

    def _words(self, value: ast.expr | None) -> str:
        return " ".join(self.text(word) for word in self._list(value)) or UNKNOWN

    def _list(self, value: ast.expr | None) -> list[ast.expr]:
        found = None if value is None else self._value(value)
        return list(found.elts) if isinstance(found, ast.List | ast.Tuple) else []

    def _value(self, value: ast.expr) -> ast.expr:
        """Follow a name to what was assigned to it."""
        for _ in range(10):
            if not (isinstance(value, ast.Name) and value.id in self._assigned):
                return value
            value = self._assigned[value.id]
        return value

    def text(self, value: ast.expr, deep: int = 0) -> str:
        """Return an expression as launch files in XML spell it."""
        value = self._value(value)
        if deep > 20:
            return UNKNOWN
        if isinstance(value, ast.Constant):
            return str(value.value).lower() if isinstance(value.value, bool) else str(value.value)
        if isinstance(value, ast.List):
            return "".join(self.text(item, deep + 1) for item in value.elts)  # substitutions one after the other
        if isinstance(value, ast.BinOp) and isinstance(value.op, ast.Add):
            return self.text(value.left, deep + 1) + self.text(value.right, deep + 1)
        if isinstance(value, ast.Call):
            return self._substitution(value, deep)
        return UNKNOWN

    def _substitution(self, call: ast.Call, deep: int) -> str:
        name = _name(call)
        arguments = [*call.args, *(k.value for k in call.keywords if k.arg in ("text", "package", "variable_name"))]
        if name == "PathJoinSubstitution":
            arguments = self._list(arguments[0]) if arguments else []
        texts = [self.text(argument, deep + 1) for argument in arguments]
        if not texts:
            return UNKNOWN
        if name in ("join", "PathJoinSubstitution"):
            return "/".join(texts)
        if name in ("TextSubstitution", "str"):
            return texts[0]
        written = {"LaunchConfiguration": "var", "EnvironmentVariable": "env", "FindPackageShare": "find-pkg-share"}
        word = written.get(name, "find-pkg-share" if name == "get_package_share_directory" else "")
        return f"$({word} {texts[0]})" if word else UNKNOWN


def _name(call: ast.Call) -> str:
    """Return the last word of what is called: `Node` of `launch_ros.actions.Node`."""
    func = call.func
    return func.attr if isinstance(func, ast.Attribute) else func.id if isinstance(func, ast.Name) else ""
