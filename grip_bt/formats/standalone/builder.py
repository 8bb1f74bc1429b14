"""What a file needs, gathered while its tree is written, and the kinds' automata as plain Python.

Of each kind's class there is what ticking needs: the methods that are asked, what these use, and the fields that they
read, which become attributes. Annotations are left out, since they name what only the document's models have.
"""

from __future__ import annotations

import ast
import inspect
import re
import sys
import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache

from pydantic import BaseModel

from grip_bt.base.errors import NotExpressibleError
from grip_bt.base.python_literals import py
from grip_bt.compilers.resolve import Part, Resolved
from grip_bt.formats.names import Identifiers
from grip_bt.formats.python_source import Bracketed, call
from grip_bt.task import model
from grip_bt.task.kinds import base
from grip_bt.task.kinds.base import every_kind

TARGET = "a stand-alone py_trees file"
_ASKED = ("reactive", "settles", "begin", "ended", "again", "settle", "over")
_FLAGS = ("resets", "concurrent", "late_exits")
_STEPS = (base.Run, base.Next, base.Stay, base.End, base.Reason, base.Ended)
_ANSWERED = {
    *("names", "ends", "kept", "at", "now", "deadline", "passed", "up", "reached", "pick", "holds", "value", "match"),
    *("items", "empty", "take", "put", "exit", "edge", "ask"),
}
"""What the container of a file answers."""
_HEAD = """\
# The kinds of nodes, as grip has them: each says which of its children are ticked.
# fmt: off


CHILD = object()


class Settings:
    def __init__(self, **settings):
        vars(self).update(settings)"""
NAMES = {"CHILD", "Settings", "Kind", "Container", *(step.__name__ for step in _STEPS)}


class KindSource:
    """The source of the kinds that one file needs, and the questions that they ask."""

    def __init__(self) -> None:
        self.questions: set[str] = set()
        self._texts: dict[object, str] = {}
        self._settings: dict[type, list[str]] = {}

    def made(self, part: Part, kind: base.Kind) -> Bracketed:
        """Return what makes a kind. Raises NotExpressibleError: it asks what such a file doesn't answer."""
        self._add(type(kind), _ASKED)
        if unknown := sorted(self.questions - _ANSWERED):
            raise NotExpressibleError(part.path, f"a {kind.kind}, which asks for `{unknown[0]}`,", TARGET)
        return self._call(kind)

    def text(self) -> str:
        """Return the classes."""
        steps = [textwrap.dedent(inspect.getsource(step)).rstrip() for step in _STEPS]
        steps = [re.sub(r": (State|Failure \| None)\b", ": Any", step) for step in steps]  # a file knows no other types
        root = _class(base.Kind, "Settings", [f"{' = '.join(_FLAGS)} = False"], _ASKED)
        return "\n\n\n".join([_HEAD, *steps, root, *self._texts.values(), "# fmt: on"])

    def _call(self, model: BaseModel) -> Bracketed:
        given: dict[str, object] = {}
        for name in self._settings[type(model)]:
            value = getattr(model, name)
            if isinstance(value, list):
                value = [self._call(item) if isinstance(item, BaseModel) else item for item in value]
            if value != type(model).model_fields[name].get_default(call_default_factory=True):
                given[name] = value
        return call(type(model).__name__, **given)

    def _add(self, cls: type[BaseModel], asked: Iterable[str], read: Iterable[str] = ()) -> None:
        """Add a class with the methods that are asked, all that these use, and the fields that they or others read."""
        if cls in self._texts:
            return
        own, called = set(read), set[str]()
        methods = [name for name in asked if name in _functions(cls)]
        for name in methods:  # which grows meanwhile
            for node in ast.walk(_functions(cls)[name][1]):
                if isinstance(node, ast.Attribute):
                    called.add(node.attr)
                    owner = node.value.id if isinstance(node.value, ast.Name) else ""
                    self.questions |= {node.attr} if owner == "q" else set()
                    own |= {node.attr} if owner == "self" else set()
                    if owner == "self" and node.attr in _functions(cls) and node.attr not in methods:
                        methods.append(node.attr)
                elif isinstance(node, ast.Name):
                    self._add_function(cls.__module__, node.id)
        fields = [name for name in cls.model_fields if name in own]
        for name in fields:
            for held in getattr(cls.model_fields[name].annotation, "__args__", ()):
                if isinstance(held, type) and issubclass(held, BaseModel):
                    self._add(held, called & set(_functions(held)), called)
        self._settings[cls] = fields
        names = [*(name for name in _FLAGS if getattr(cls, name, False)), *sorted(own - {*fields, *methods})]
        attributes = [f"{name} = {py(getattr(cls, name))}" for name in names if hasattr(cls, name)]
        for name in fields:
            if not cls.model_fields[name].is_required():
                default = cls.model_fields[name].get_default(call_default_factory=True)
                attributes.append(f"{name} = {py(tuple(default) if isinstance(default, list) else default)}")
        self._texts[cls] = _class(cls, "Kind" if issubclass(cls, base.Kind) else "Settings", attributes, methods)

    def _add_function(self, module: str, name: str) -> None:
        found = vars(sys.modules[module]).get(name)
        if inspect.isfunction(found) and found.__module__ == module and found not in self._texts:
            lines = inspect.getsource(found).split("\n")
            (tree,) = ast.parse("\n".join(lines)).body
            assert isinstance(tree, ast.FunctionDef), "it is one"
            self._texts[found] = _function(lines, tree)
            for node in ast.walk(tree):
                if isinstance(node, ast.Name):
                    self._add_function(module, node.id)


@cache
def _functions(cls: type) -> dict[str, tuple[list[str], ast.FunctionDef]]:
    """Return the methods of a class and of its bases that are kinds too: name -> (lines of its class, syntax)."""
    found: dict[str, tuple[list[str], ast.FunctionDef]] = {}
    for each in cls.__mro__:
        if each.__module__ == base.__name__ and each is not cls:
            break
        lines = textwrap.dedent(inspect.getsource(each)).split("\n")
        (tree,) = ast.parse("\n".join(lines)).body
        assert isinstance(tree, ast.ClassDef), "it is one"
        for node in tree.body:
            if isinstance(node, ast.FunctionDef):
                found.setdefault(node.name, (lines, node))
        if not issubclass(cls, base.Kind):
            break
    return found


def _class(cls: type, parent: str, attributes: Sequence[str], methods: Iterable[str]) -> str:
    doc = (inspect.getdoc(cls) or "").split("\n\n")[0].replace("\n", "\n    ")
    blocks = [f'class {cls.__name__}({parent}):\n    """{doc}"""']
    if attributes:
        blocks.append("\n".join(f"    {line}" for line in attributes))
    return "\n\n".join([*blocks, *(_function(*_functions(cls)[name], "    ") for name in methods)])


def _function(lines: list[str], tree: ast.FunctionDef, indent: str = "") -> str:
    """Return the source of a function without annotations."""
    for argument in (*tree.args.args, *tree.args.kwonlyargs):
        argument.annotation = None
    decorators = [f"{indent}@{ast.unparse(each)}" for each in tree.decorator_list]
    head = f"{indent}def {tree.name}({ast.unparse(tree.args)}):"
    return "\n".join([*decorators, head, *lines[tree.body[0].lineno - 1 : tree.end_lineno]])


ORDER = (
    *("variable", "bind", "labels", "scope", "precondition", "same", "kinds", "container"),
    *("fail", "log", "assign", "foreign"),
)
"""Supporting parts, in the order in which the file has them."""
_OWN_NAMES = (
    *("py_trees", "Status", "Any", "Callable", "Iterator", "Mapping", "NamedTuple", "copy", "time", "logging"),
    *("Variable", "Scope", "Precondition", "Fail", "Log", "Foreign", "Real", "is_truth", "same"),
    *("bind", "outcome_of", "code_of", "carried_code", "look_up", "create_root", "end_of", "run", "ENDS"),
    *("Leaf", "Context", "RunContext", "Catalog", "Manifest", "load_implementation", "NODES", "Path", "HERE"),
    *(kind.__name__ for kind in every_kind()),
    *NAMES,
)


@dataclass
class ModuleBuilder:
    """The file under construction: the body of `create_root`, and what that uses: parts, classes, manifests, cells.

    `codes`: whether an edge asks for the code of a failure. `imports`: module -> class -> its name in the file.
    """

    grip: bool = False
    codes: bool = False
    identifiers: Identifiers = field(default_factory=lambda: Identifiers(_OWN_NAMES))
    parts: set[str] = field(default_factory=lambda: {"labels"})
    kinds: KindSource = field(default_factory=KindSource)
    imports: dict[str, dict[str, str]] = field(default_factory=dict)
    builtin: bool = False
    manifests: dict[str, str] = field(default_factory=dict)
    variables: dict[int, str] = field(default_factory=dict)
    statements: list[str] = field(default_factory=list)

    def visible(self, part: Part, *, around: bool = False) -> dict[str, str]:
        """Return the variables that a node sees: name in the task -> name in the file."""
        scope = part.around if around else part.scope
        cells = ((name, scope.find(name)) for name in scope.visible())
        return {name: self.variables[id(cell)] for name, cell in cells if cell is not None}


def asks_for_codes(resolved: Resolved) -> bool:
    """Tell whether some edge is refined by a failure code."""
    tables = [resolved.ends, *(edges for part in resolved.root.walk() for edges in (part.exits, part.edges))]
    rules = [rule for part in resolved.root.walk() for rule in getattr(part.node, "rules", ())]
    said = [label for rule in rules for one in rule.when.values() for label in ([one] if isinstance(one, str) else one)]
    return any(code is not None for table in tables for (_, _, code), _ in table) or any("." in s for s in said)


def is_fresh(part: Part) -> bool:
    """Tell whether the node has variables that begin anew when it is entered."""
    return part.declares and not isinstance(part.node, model.Leaf)
