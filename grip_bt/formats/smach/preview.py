"""What a legacy file shows without being run: where it makes containers, and a preview of what they are.

A preview takes the text by its word: `with sm:` and `add` in the order of their lines. It is exact where the file has
nothing else that could make a difference: states and machines of literals throughout.
"""

from __future__ import annotations

import ast
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grip_bt.base.errors import DocumentError
from grip_bt.nodes.smach_source import read_source

from .found import CONTAINERS, FIXED_OUTCOMES, Child, ContainerInfo, Span, StateInfo, Way

# Positional parameters of upstream's constructors.
PARAMETERS = {
    "State": ("outcomes", "input_keys", "output_keys", "io_keys"),
    "StateMachine": ("outcomes", "input_keys", "output_keys"),
    "Sequence": ("outcomes", "connector_outcome", "input_keys", "output_keys"),
    "Concurrence": (
        "outcomes",
        "default_outcome",
        "input_keys",
        "output_keys",
        "outcome_map",
        "outcome_cb",
        "child_termination_cb",
    ),
    "Iterator": ("outcomes", "input_keys", "output_keys", "it", "it_label", "exhausted_outcome"),
}
_ADD = {
    "add": ("label", "state", "transitions", "remapping"),
    "set_contained_state": ("label", "state", "loop_outcomes"),
}
_UNKNOWN = object()


@dataclass(frozen=True)
class Place:
    """Where a text makes a container, or has a class of them (`cls`); `around`: the function or class that it is in."""

    kind: str
    line: int
    end_line: int
    cls: str = ""
    around: str = ""


def places_of(file: Path) -> list[Place]:
    """Return where a file makes containers; none where it isn't Python."""
    try:
        tree = read_source(file).tree
    except DocumentError:
        return []
    found = []
    for around in tree.body:
        name = getattr(around, "name", "") if isinstance(around, (ast.ClassDef, ast.FunctionDef)) else ""
        for node in ast.walk(around):
            kind = next((k for base in node.bases if (k := _kind(base))), "") if isinstance(node, ast.ClassDef) else ""
            if kind and isinstance(node, ast.ClassDef):
                found.append(Place(kind, node.lineno, node.end_lineno or node.lineno, node.name, name))
            elif isinstance(node, ast.Call) and _kind(node.func):
                found.append(Place(_kind(node.func), node.lineno, node.end_lineno or node.lineno, "", name))
    return found


def _kind(node: ast.expr) -> str:
    """Return the container class of smach that an expression names."""
    match node:
        case ast.Name(name) | ast.Attribute(ast.Name("smach"), name) if name in CONTAINERS:
            return name
    return ""


def preview(file: Path) -> list[ContainerInfo]:
    """Return the containers of a file, as its text shows them.

    Raises:
        DocumentError: it isn't Python.
    """
    tree = read_source(file).tree
    reader = _Reader(file, tree)
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            reader.function(node, node.name)
        elif isinstance(node, ast.ClassDef):
            for method in node.body:
                if isinstance(method, ast.FunctionDef):
                    own = (
                        next((k for base in node.bases if (k := _kind(base))), "") if method.name == "__init__" else ""
                    )
                    reader.function(method, node.name, own, node)
    reader.function(ast.Module(tree.body, []), "")
    found = reader.found
    for container in found:
        if not reader.literal or id(container) in reader.doubtful:
            container.outermost.problem(
                "partial", "a preview of the text: whether it is so shows when it is built, with --execute"
            )
    return sorted(found, key=lambda c: c.span.line)


class _Reader:
    def __init__(self, file: Path, tree: ast.Module):
        self.file, self.found, self.doubtful = file, list[ContainerInfo](), set[int]()
        self.classes = {n.name: n for n in tree.body if isinstance(n, ast.ClassDef)}
        self.literal = all(map(_harmless, tree.body))
        names = [n.name for n in tree.body if isinstance(n, (ast.ClassDef, ast.FunctionDef))]
        self.literal &= len(names) == len(set(names))

    def function(self, node: Any, name: str, own: str = "", cls: ast.ClassDef | None = None) -> None:
        """Read a function or method; `own`: the kind of container that its `self` is."""
        known: dict[str, ContainerInfo] = {}
        if own and cls is not None:
            known["self"] = self._new(own, cls.name, cls, _named(node, own))
        before = len(self.found) - len(known)
        self._block(node.body, known, None, plain=True)
        arguments = getattr(node, "args", None)
        required = (
            [] if arguments is None else arguments.args[bool(cls) : len(arguments.args) - len(arguments.defaults)]
        )
        for made in self.found[before:]:
            returned = next(
                (n.value.id for n in ast.walk(node) if isinstance(n, ast.Return) and isinstance(n.value, ast.Name)), ""
            )
            direct = made is known.get("self") or (cls is None and made is known.get(returned)) or not name
            variable = next((n for n, c in known.items() if c is made), "")
            if made.parent is None:
                builder = name or variable or "__main__"
                made.way = Way(
                    builder, self.file, made.span.line, (), tuple(a.arg for a in required), direct, bool(name)
                )
            if (
                cls is not None
                or required
                or not name
                or any(isinstance(n, (ast.Yield, ast.Await)) for n in ast.walk(node))
            ):
                self.doubtful |= {id(made)}
            if getattr(node, "decorator_list", None):
                self.doubtful |= {id(made)}

    def _block(
        self, body: list[ast.stmt], known: dict[str, ContainerInfo], opened: ContainerInfo | None, plain: bool
    ) -> None:
        for statement in body:
            match statement:
                case ast.Assign([ast.Name(name)], ast.Call() as call) if _kind(call.func):
                    known[name] = self._new(_kind(call.func), _kind(call.func), call, call)
                    if not plain:
                        self.doubtful.add(id(known[name]))
                case ast.With([ast.withitem(ast.Name(name))], inner) if name in known:
                    self._block(inner, known, known[name], plain)
                case ast.Expr(ast.Call(ast.Attribute(_, method), _) as call) if method in _ADD and opened is not None:
                    self._add(opened, call, known, method)
                    if not plain:
                        self.doubtful.add(id(opened))
                case ast.Return(ast.Name()) | ast.Return(None) | ast.Expr(ast.Constant()) | ast.Pass():
                    pass
                case ast.FunctionDef() | ast.ClassDef() | ast.Import() | ast.ImportFrom():
                    pass
                case ast.If(test) if ast.unparse(test) in ("__name__ == '__main__'",):
                    self._block(statement.body, known, opened, plain)
                case _:
                    if known:  # whatever it does, it may do it to one of them
                        self.doubtful |= {id(c) for c in known.values()}
                    for inner in (getattr(statement, part, []) for part in ("body", "orelse", "finalbody")):
                        if isinstance(inner, list):
                            self._block(inner, known, opened, plain=False)

    def _new(self, kind: str, cls: str, node: Any, given: ast.Call | None) -> ContainerInfo:
        made = ContainerInfo(kind, cls, Span(self.file, node.lineno))
        values = _values(given, PARAMETERS[kind]) if given is not None else {}
        made.outcomes = _words(values.get("outcomes"))
        made.input_keys, made.output_keys = (
            _words(values.get("input_keys", [])) or [],
            _words(values.get("output_keys", [])) or [],
        )
        made.settings = {k: v for k, v in values.items() if k not in ("outcomes", "input_keys", "output_keys")}
        if given is None or any(v is _UNKNOWN for v in values.values()) or kind != "StateMachine":
            self.doubtful.add(id(made))
            made.settings = {k: v for k, v in made.settings.items() if v is not _UNKNOWN}
        self.found.append(made)
        return made

    def _add(self, opened: ContainerInfo, call: ast.Call, known: dict[str, ContainerInfo], method: str) -> None:
        values = dict(zip(_ADD[method], call.args, strict=False)) | {k.arg: k.value for k in call.keywords if k.arg}
        label, transitions = (_literal(values.get(key)) for key in ("label", "transitions"))
        remapping = _literal(values.get("remapping"))
        doubtful = (
            set(values) - set(_ADD["add"])
            or opened.kind != "StateMachine"
            or any(v is _UNKNOWN for v in (label, transitions, remapping))
        )
        span = Span(self.file, call.lineno)
        state = values.get("state")
        if not isinstance(label, str) or state is None or label in opened.added:
            self.doubtful.add(id(opened))
            return
        inner = known.get(state.id) if isinstance(state, ast.Name) else None
        found: StateInfo = (
            inner if inner is not None and inner.parent is None and inner is not opened else self._state(state, opened)
        )
        if isinstance(found, ContainerInfo):
            found.parent = opened
            doubtful = doubtful or id(found) in self.doubtful
        rows = {k: v for k, v in transitions.items() if isinstance(k, str)} if isinstance(transitions, dict) else {}
        if found.outcomes is None:
            doubtful = True
            found.outcomes = list(rows) or None
        elif set(rows) - set(found.outcomes):
            doubtful, found.outcomes = True, list(dict.fromkeys((*found.outcomes, *rows)))
        found.parent = opened
        renamed = remapping if isinstance(remapping, dict) else {}
        opened.added[label] = Child(label, found, rows, renamed, span)
        opened.initial = opened.initial or label
        if doubtful or set(rows.values()) & {None}:
            self.doubtful.add(id(opened))

    def _state(self, node: ast.expr, opened: ContainerInfo) -> StateInfo:
        callee = node.func if isinstance(node, ast.Call) else node
        name = ast.unparse(callee).split(".")[-1]
        name = name if name.isidentifier() else "State"
        found = StateInfo("", name, Span(self.file, node.lineno))
        cls = self.classes.get(name) if isinstance(callee, ast.Name) else None
        if name in FIXED_OUTCOMES:
            found.kind, found.outcomes = name, list(FIXED_OUTCOMES[name])
            self.doubtful.add(id(opened))
        elif cls is not None and isinstance(node, ast.Call):
            init = next((n for n in cls.body if isinstance(n, ast.FunctionDef) and n.name == "__init__"), None)
            values = _values(_named(init, "State"), PARAMETERS["State"]) if init is not None else {}
            both = _words(values.get("io_keys", [])) or []
            found.kind, found.outcomes = "State", _words(values.get("outcomes"))
            found.input_keys = [*(_words(values.get("input_keys", [])) or []), *both]
            found.output_keys = [*(_words(values.get("output_keys", [])) or []), *both]
            if init is None or not _plain_state(cls, init) or any(v is _UNKNOWN for v in values.values()):
                self.doubtful.add(id(opened))
            given = [*node.args, *(k.value for k in node.keywords)]
            if any(_literal(a) is _UNKNOWN for a in given):
                self.doubtful.add(id(opened))
        else:
            self.doubtful.add(id(opened))
        return found


def _named(function: Any, kind: str) -> ast.Call | None:
    """Return the call of the base's constructor in one."""
    for statement in function.body:
        match statement:
            case ast.Expr(ast.Call(ast.Attribute(ast.Call(ast.Name("super")), "__init__")) as call):
                return call
            case ast.Expr(ast.Call(ast.Attribute(base, "__init__"), [ast.Name("self"), *rest]) as call) if ast.unparse(
                base
            ).endswith(kind):
                return ast.Call(call.func, rest, call.keywords)
    return None


def _values(call: ast.Call | None, names: tuple[str, ...]) -> dict[str, Any]:
    if call is None:
        return {}
    given = dict(zip(names, call.args, strict=False)) | {k.arg or "": k.value for k in call.keywords}
    return {name: _literal(value) for name, value in given.items()}


def _literal(node: ast.expr | None) -> Any:
    if node is None:
        return {}
    try:
        return ast.literal_eval(node)
    except (ValueError, TypeError, SyntaxError, MemoryError):
        return _UNKNOWN


def _words(value: object) -> list[str] | None:
    if isinstance(value, (list, tuple)) and all(isinstance(w, str) for w in value):
        return list(dict.fromkeys(value))
    return None


def _plain_state(cls: ast.ClassDef, init: ast.FunctionDef) -> bool:
    """Whether a class is smach's State with a constructor that only calls State's and keeps what it is given."""
    base = len(cls.bases) == 1 and ast.unparse(cls.bases[0]) in ("smach.State", "State")
    methods = {n.name for n in cls.body if isinstance(n, ast.FunctionDef)} <= {"__init__", "execute"}
    plain = not cls.keywords and not cls.decorator_list and not init.decorator_list
    return base and methods and plain and all(map(_keeps, init.body)) and all(map(_harmless, cls.body))


def _keeps(statement: ast.stmt) -> bool:
    match statement:
        case ast.Assign([ast.Attribute(ast.Name("self"), name)], value):
            return not name.startswith("_") and name not in ("execute",) and isinstance(value, (ast.Name, ast.Constant))
        case ast.Expr(ast.Call(ast.Attribute(_, "__init__"))) | ast.Expr(ast.Constant()):
            return True
    return False


def _harmless(statement: ast.stmt) -> bool:
    """Whether a statement outside of functions only names things, so that nothing is other than it says."""
    match statement:
        case ast.Import(names):
            return all(
                n.name in ("smach", "rospy", "smach_ros", "time", "math", "random") and not n.asname for n in names
            )
        case ast.ImportFrom(module, names):
            return module == "smach" and all(not n.asname and n.name != "*" for n in names)
        case ast.FunctionDef():
            return not statement.decorator_list
        case ast.ClassDef():
            return not statement.decorator_list and not statement.keywords and all(map(_harmless, statement.body))
        case ast.Expr(ast.Constant()) | ast.Pass():
            return True
        case ast.If(test):
            return ast.unparse(test) == "__name__ == '__main__'"
    return False
