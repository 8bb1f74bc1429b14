"""Any task -> nodes of BehaviorTree.CPP that do the same, tick by tick, where no element says it directly.

Two entries tell how the node that has ended last did: `outcome` its label, `code` why it failed. Whoever has labelled
ways out asks them; a leaf writes them by its output ports of these names. Entries that begin with `at_`, `done_` and so
on are states of containers; variables of inner scopes get names of their own.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from grip_bt.base.errors import NotExpressibleError
from grip_bt.base.expression import parse_expression
from grip_bt.base.frozen import FrozenDict
from grip_bt.compilers.resolve import Part, Resolved
from grip_bt.compilers.scopes import UNSET, Cell
from grip_bt.formats.blackboard import text_of_value
from grip_bt.formats.names import free
from grip_bt.formats.xml_trees import leaf_attributes
from grip_bt.task import model
from grip_bt.task.catalog import Manifest
from grip_bt.task.catalog.manifest import Parameter
from grip_bt.task.kinds.control import Control
from grip_bt.task.kinds.round_robin import RoundRobin

from .leaves import GROUP
from .lowered import (
    TARGET,
    Xml,
    any_of,
    chosen,
    holds,
    leads,
    milliseconds,
    parallel,
    script,
    script_of,
    tag_of,
    tells,
    xml,
)

_UNWRITTEN = -(2**52)
_LOOPS = (model.StateMachine, model.Retry, model.Repeat, model.Loop)
_NATURAL = {"success": "success", "failure": "failure"}
_WELL, _FAILED = "outcome := 'success'; code := ''", "outcome := 'failure'; code := "


class Lowering:
    """Writes the parts of one task; `used` are the manifests of its leaves."""

    def __init__(self, used: dict[str, Manifest]):
        self.used = used
        self.asked: list[str] = []
        self._cells: dict[int, str] = {}
        self._taken: set[str] = {"outcome", "code", "true", "false"}
        self._first: list[str] = []

    def document(self, resolved: Resolved) -> Xml:
        """Return the main tree of a task. Raises NotExpressibleError: BT.CPP has no words for a part of it."""
        root, meaning = resolved.root, resolved.task.outcomes
        if resolved.task.outputs:
            raise NotExpressibleError("/", "outputs of a task", TARGET)
        body = self.node(root)
        cells = [cell for cell in resolved.scopes[""].cells.values() if not isinstance(cell.initial, list | dict)]
        first = ["outcome := ''", "code := ''", *self._first, *(self._begin(root, cells) if cells else ())]
        if any(meaning[to] != root.meaning.get(label) or to != label for (_, label, _), to in resolved.ends):
            ends = self.entry("done")
            ways = [way for child in {edge[0] for edge, _ in resolved.ends} for way in leads(resolved.ends, child)]
            note = script(f"{ends} := {chosen(ways, 'outcome')}", f"outcome := {ends}")
            body = xml("Sequence", xml("ForceSuccess", body), note, self.verdict(ends, meaning))
        return xml("Sequence", script(*first), body)

    def refuse(self, part: Part, what: str) -> NotExpressibleError:
        """Return the error that names a part."""
        return NotExpressibleError(part.path, what, TARGET)

    def entry(self, wanted: str) -> str:
        """Return a name for an entry that nobody has."""
        name = free(wanted, self._taken)
        self._taken.add(name)
        return name

    def verdict(self, entry: str, meaning: Mapping[str, str]) -> Xml:
        """Return what succeeds where a label means success."""
        well = [label for label, means in meaning.items() if means == "success"]
        return holds(any_of(f"{entry} == '{label}'" for label in well), _onSuccess="code := ''")

    def node(self, part: Part) -> Xml:
        """Return a part; it ends with its meaning, and `outcome` and `code` say the rest."""
        made = self._leaf(part) if isinstance(part.node, model.Leaf) else self._container(part)
        if part.node.precondition:
            condition = self._text(part, part.node.precondition, around=True)
            made = xml("Sequence", holds(condition, _onFailure=f"{_FAILED}'precondition'"), made)
            if part.meaning.get("failure") == "success":
                raise self.refuse(part, "a precondition whose failure means success")
        if part.node.doc:
            made.set("_description", part.node.doc)
        return made

    def _name_of(self, cell: Cell) -> str:
        if isinstance(cell.initial, list | dict):
            raise NotExpressibleError("/", f"the initial value of the variable {cell.name!r}", TARGET)
        if id(cell) not in self._cells:
            self._cells[id(cell)] = self.entry(cell.name)
        return self._cells[id(cell)]

    def _text(self, part: Part, expression: str, bound: Mapping[str, str] | None = None, around: bool = False) -> str:
        """Return an expression as a script; `bound`: its names -> variables, which it calls as they are by default."""
        scope = part.around if around else part.scope
        cells = {name: scope.cell((bound or {}).get(name, name)) for name in parse_expression(expression).names}
        known = {name: self._name_of(cell) for name, cell in cells.items()}
        types = {known[name]: cell.type for name, cell in cells.items()}
        try:
            return script_of(expression, lambda name: types.get(name, "Any"), known)
        except ValueError as error:
            raise self.refuse(part, f"`{expression}` ({error})") from error

    def _begin(self, part: Part, cells: Iterable[Cell] = ()) -> list[str]:
        found = list(cells or (part.scope.cells.values() if part.declares else ()))
        return [f"{self._name_of(cell)} := {self._value(part, cell.initial)}" for cell in found if _has_initial(cell)]

    def _value(self, part: Part, value: Any) -> str:
        if not isinstance(value, bool | int | float | str):
            raise self.refuse(part, f"the value {value!r} of a variable")
        try:
            return script_of(repr(value), lambda name: "Any")
        except ValueError as error:
            raise self.refuse(part, f"the value {value!r} ({error})") from error

    # --- leaves ---

    def _leaf(self, part: Part) -> Xml:
        node, manifest = part.node, part.manifest
        assert isinstance(node, model.Leaf), "of leaves"
        assert manifest is not None, "resolved leaves have a manifest"
        match node.node:
            case "flow/succeed":
                return xml("AlwaysSuccess", _onSuccess=_WELL)
            case "flow/fail":
                return xml("AlwaysFailure", _onFailure=f"{_FAILED}'{node.with_.get('code', 'failed')}'")
            case "flow/wait":
                return xml("Sleep", msec=milliseconds(part, node.with_["seconds"]), _onSuccess=_WELL)
            case "flow/set" | "flow/compute" if node.out:
                target, given = self._name_of(part.scope.cell(node.out["value"])), node.with_
                value = self._text(part, given["expression"], node.in_) if "expression" in given else None
                return script(f"{target} := {value or self._value(part, given['value'])}", _onSuccess=_WELL)
        self.used[manifest.id] = manifest
        said = leaf_attributes(part, node, _literal, TARGET, lambda name: self._name_of(part.scope.cell(name)))
        if tells(manifest):
            said |= {"outcome": "{outcome}", "code": "{code}"}
        else:
            said |= {"_onSuccess": _WELL, "_onFailure": f"{_FAILED}''"}
        if self.asked:
            said["preempt"] = f"{{{self.asked[-1]}}}"
        made = xml(tag_of(manifest), name=part.path, **said)
        if any(part.meaning.get(end) != meaning for end, meaning in manifest.outcomes.items()):
            return xml("Sequence", xml("ForceSuccess", made), self.verdict("outcome", part.meaning))
        return made

    def _foreign(self, part: Part, node: model.Foreign) -> Xml:
        """Return a behaviour of py_trees as a leaf, to be written in C++."""
        name = node.behaviour.partition(":")[2].rpartition(".")[2]
        args = {port: value for port, value in node.args.items() if port != "name"}  # which every node has
        ports = {port: Parameter(type="Any") for port in args}
        face = Manifest(id=f"{GROUP}/{name}", doc=node.behaviour, implementation="", parameters=FrozenDict(ports))
        self.used[face.id] = face
        try:
            given = {port: _literal(value, "Any") for port, value in args.items()}
        except ValueError as error:
            raise self.refuse(part, f"its arguments ({error})") from error
        return xml(name, name=part.path, **given, _onSuccess=_WELL, _onFailure=f"{_FAILED}'foreign'")

    def _control(self, part: Part) -> Xml:
        decides, *others = part.children
        if decides.manifest is None or part.exits or decides.manifest.id in ("btcpp/OnHalted", "btcpp/Switch"):
            raise self.refuse(part, "a control whose ends are labelled, or whose leaf has no element")
        made = self._leaf(decides)
        made.extend(self.node(child) for child in others)
        return made

    # --- containers ---

    def _container(self, part: Part) -> Xml:
        node = part.node
        match node:
            case model.Sequence() | model.Fallback():
                made = self._series(part, node)
            case model.Switch():
                made = self._switch(part, node)
            case RoundRobin():
                made = self._turns(part)
            case model.Parallel():
                made = parallel(self, part, node)
            case model.Guard():
                asked = holds(self._text(part, node.if_), _onFailure=f"{_FAILED}'guard'")
                made = xml("ReactiveSequence", asked, self._ending(part, part.children[0]))
            case model.Timeout(child_first=False, seconds=seconds):
                made = self._timeout(part, seconds)
            case model.Invert() | model.Force():
                made = self._ending(part, part.children[0])
            case model.ForEach():
                made = self._each(part, node)
            case model.Foreign():
                made = self._foreign(part, node)
            case model.Subtask():
                return self._subtask(part, node)
            case Control():
                made = self._control(part)
            case _ if isinstance(node, _LOOPS):
                made = self._loop(part)
            case _:
                raise self.refuse(part, f"a {getattr(node, 'kind', 'leaf')}")
        first = self._begin(part)
        return xml("Sequence", script(*first), made) if first else made

    def _target(self, part: Part, child: Part, natural: Mapping[str, str]) -> str:
        """Return where a container goes after a child; `natural`: meaning of its end -> label, or '' to go on."""
        means = [(f"outcome == '{label}'", f"'{natural[means]}'") for label, means in child.meaning.items()]
        return chosen([*leads(part.exits, child.name), *means], "''")

    def _ended(self, part: Part, child: Part, done: str, natural: Mapping[str, str], *more: str) -> list[Xml]:
        """Return a child, run to its end, and what notes where that leads."""
        note = script(f"{done} := {self._target(part, child, natural)}", *more)
        return [xml("ForceSuccess", self.node(child)), note]

    def _finish(self, part: Part, done: str, body: Xml, first: Sequence[str] = ()) -> Xml:
        start = [script(*first)] if first else []
        end = [script(f"outcome := {done}"), self.verdict(done, part.meaning)]
        return xml("Sequence", *start, xml("ForceSuccess", body), *end)

    def _series(self, part: Part, node: model.Sequence | model.Fallback) -> Xml:
        if not part.children:
            end = self.verdict("outcome", part.meaning)
            return xml("Sequence", script(f"outcome := '{node.onward}'", "code := ''"), end)
        done, steps = self.entry("done"), []
        for child in part.children:
            way = _NATURAL if child is part.children[-1] else {**_NATURAL, node.onward: ""}
            steps.append(xml("Sequence", *self._ended(part, child, done, way), holds(f"{done} == ''")))
        return self._finish(part, done, xml("Sequence" if node.memory else "ReactiveSequence", *steps))

    def _ending(self, part: Part, child: Part) -> Xml:
        """Return the one child of a decorator or chooser, after which it ends."""
        done, node, natural, more = self.entry("done"), part.node, dict(_NATURAL), list[str]()
        if isinstance(node, model.Invert):
            natural = {"success": "failure", "failure": "success"}
            exited = any_of(condition for condition, _ in leads(part.exits, child.name))
            more = [f"code := ({exited} ? code : '')"]
        elif isinstance(node, model.Force):
            natural = dict.fromkeys(natural, node.as_)
        ended = self._ended(part, child, done, natural, *more, f"outcome := {done}")
        return xml("Sequence", *ended, self.verdict(done, part.meaning))

    def _chosen_child(self, entry: str, ways: Sequence[Xml]) -> Xml:
        """Return a Switch over the number of a child; more than six are in a Switch of its own."""
        if len(ways) == 1:
            return ways[0]
        first, rest = ways[:6], xml("AlwaysFailure")
        if more := ways[6:]:
            inner = self.entry("at")
            rest = xml("ReactiveSequence", script(f"{inner} := {entry} - 6"), self._chosen_child(inner, more))
        cases = {f"case_{i}": str(i) for i in range(1, len(first) + 1)}
        return xml(f"Switch{len(first)}", *first, rest, variable=f"{{{entry}}}", **cases)

    def _switch(self, part: Part, node: model.Switch) -> Xml:
        at, names = self.entry("at"), [child.name for child in part.children]
        ways = []
        for child, literal in node.literals():
            tree = ast.unparse(ast.Compare(parse_expression(node.on_value).tree, [ast.Eq()], [ast.Constant(literal)]))
            ways.append((self._text(part, tree), str(names.index(child) + 1 if child in names else 0)))
        other = str(names.index(node.default) + 1) if node.default in names else str(len(names) + 1)
        none = xml("AlwaysFailure", _onFailure=f"{_FAILED}'no_case'")
        children = [*(self._ending(part, child) for child in part.children), none]
        pick = script(f"{at} := {chosen(ways, other)}")
        return xml("Sequence" if node.memory else "ReactiveSequence", pick, self._chosen_child(at, children))

    def _turns(self, part: Part) -> Xml:
        """Return a round robin; whose turn it is stands in an entry, which begins with the task."""
        turn, at, size = self.entry("turn"), self.entry("at"), len(part.children)
        self._first.append(f"{turn} := 0")
        pick = script(f"{at} := {turn} + 1", f"{turn} := ({turn} == {size - 1} ? 0 : {turn} + 1)")
        return xml("Sequence", pick, self._chosen_child(at, [self._ending(part, c) for c in part.children]))

    def _timeout(self, part: Part, seconds: float) -> Xml:
        over, inner = self.entry("over"), self._ending(part, part.children[0])
        inner.set("_post", f"{over} := 1")
        late = f"outcome := ({over} == 1 ? outcome : 'failure'); code := ({over} == 1 ? code : 'time_out')"
        limit = xml("Timeout", inner, msec=milliseconds(part, seconds), _onFailure=late)
        return xml("Sequence", script(f"{over} := 0"), limit)

    def _each(self, part: Part, node: model.ForEach) -> Xml:
        cell = part.scope.cell(node.items)
        if not isinstance(cell.initial, list) or not all(type(item) is int for item in cell.initial):
            raise self.refuse(part, "a for_each over anything but a literal list of whole numbers")
        item = self._name_of(part.scope.cells[node.item])
        if not cell.initial:
            return xml("AlwaysSuccess", _onSuccess=_WELL)
        done = self.entry("done")
        ended = self._ended(part, part.children[0], done, {"success": "", "failure": "failure"})
        body = xml("Sequence", *ended, holds(f"{done} == ''"))
        loop = xml("LoopInt", body, queue=";".join(map(str, cell.initial)), value=f"{{{item}}}")
        end = script(f"{done} := ({done} == '' ? 'success' : {done})")
        return self._finish(
            part, done, xml("Sequence", xml("ForceSuccess", loop), end), [f"{done} := ''", "code := ''"]
        )

    def _loop(self, part: Part) -> Xml:
        """Return what goes on with the next tick after each child: a machine, attempts, passes."""
        node, done, at = part.node, self.entry("done"), self.entry("at")
        if isinstance(node, model.StateMachine):
            names = [child.name for child in part.children]
            first = f"{at} := {names.index(node.initial) + 1}"
            body = [self._chosen_child(at, [self._step(part, child, done, at, names) for child in part.children])]
        else:
            first, child, times, more = f"{at} := 0", part.children[0], getattr(node, "times", None), list[str]()
            again, stop = ("failure", "success") if isinstance(node, model.Retry) else ("success", "failure")
            body = [script(f"{at} := {at} + 1")]
            if isinstance(node, model.Loop):
                before = []
                if node.while_:
                    before.append(f"{done} := ({self._text(part, node.while_)} ? '' : 'success')")
                    before.append(f"code := ({done} == '' ? code : '')")
                if times is not None:
                    over = f"({done} == '' && {at} >= {times})"
                    before += [f"code := ({over} ? 'loop_limit' : code)", f"{done} := ({over} ? 'failure' : {done})"]
                body[:0] = [script(*before), holds(f"{done} == ''")] if before else []
            elif times is not None:
                more.append(f"{done} := (({done} == '' && {at} >= {times}) ? '{again}' : {done})")
            body += self._ended(part, child, done, {again: "", stop: stop}, *more)
        loop = xml("KeepRunningUntilFailure", xml("Sequence", *body, holds(f"{done} == ''")))
        return self._finish(part, done, loop, [f"{done} := ''", first])

    def _step(self, part: Part, child: Part, done: str, at: str, names: list[str]) -> Xml:
        ways = leads(part.edges, child.name, "")
        to_state = [(asked, str(names.index(label) + 1)) for asked, label in ways if label in names]
        to_end = [(asked, f"'{label}'" if label not in names else "''") for asked, label in ways]
        note = script(f"{done} := " + chosen(to_end, "''"), f"{at} := {chosen(to_state, at)}")
        return xml("Sequence", xml("ForceSuccess", self.node(child)), note)

    def _subtask(self, part: Part, node: model.Subtask) -> Xml:
        task, outside, done = part.scope.cells, part.outside, self.entry("done")
        assert outside is not None, "of subtasks"
        others = [cell for name, cell in task.items() if name not in node.with_ and name not in node.in_]
        first = self._begin(part, others) if others else []
        first += [f"{self._name_of(task[p])} := {self._name_of(outside.cell(v))}" for p, v in node.in_.items()]
        first += [f"{self._name_of(task[port])} := {self._value(part, value)}" for port, value in node.with_.items()]
        body = xml("Sequence", *self._ended(part, part.children[0], done, _NATURAL))
        for port, variable in node.out.items():  # copied where it was written
            name, outer = self._name_of(task[port]), self._name_of(outside.cell(variable))
            if task[port].type != "int":
                raise self.refuse(part, f"the output {port!r} of a subtask, of type {task[port].type}")
            if port not in node.in_ and port not in node.with_ and not _has_initial(task[port]):
                first.append(f"{name} := {_UNWRITTEN}")
            told = xml("Sequence", holds(f"{name} != {_UNWRITTEN}"), script(f"{outer} := {name}"))
            body.append(xml("ForceSuccess", told))
        return self._finish(part, done, body, first or [f"{done} := ''"])


def _has_initial(cell: Cell) -> bool:
    """Tell whether a variable has an initial value; null is none."""
    return cell.initial is not UNSET and cell.initial is not None and not isinstance(cell.initial, list)


def _literal(value: object, kind: str) -> str:
    return str(value) if kind == "Any" and type(value) in (int, float) else text_of_value(value, kind)
