"""Any task -> nodes of BehaviorTree.CPP that do the same, tick by tick, where no element says it directly.

Two entries tell how the node that has ended last did: `outcome` its label, `code` why it failed. Whoever has labelled
ways out asks them; a leaf writes them by its output ports of these names. Entries that begin with `at_`, `done_` and so
on are states of containers; variables of inner scopes get names of their own.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Sequence
from typing import Any

from grip_bt.base.errors import NotExpressibleError
from grip_bt.base.expression import parse_expression
from grip_bt.base.frozen import FrozenDict
from grip_bt.compilers.resolve import Part, Resolved
from grip_bt.compilers.scopes import UNSET, Cell
from grip_bt.formats.names import free
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
    around,
    chosen,
    holds,
    labelled,
    leads,
    milliseconds,
    said_of,
    script,
    tag_of,
    tells,
)
from .lowered_parallel import parallel
from .script_text import attribute_text, script_of

_UNWRITTEN = -(2**52)
_LOOPS = (model.StateMachine, model.Retry, model.Repeat, model.Loop)


class Lowering:
    """Writes the parts of one task; `used` are the manifests of its leaves."""

    def __init__(self, used: dict[str, Manifest]):
        self.used = used
        self.cells: dict[int, str] = {}
        self.taken: set[str] = {"outcome", "code", "true", "false"}
        self.first: list[str] = []
        self.asked: list[str] = []

    def refuse(self, part: Part, what: str) -> NotExpressibleError:
        """Return the error that names a part."""
        return NotExpressibleError(part.path, what, TARGET)

    def entry(self, wanted: str) -> str:
        """Return a name for an entry that nobody has."""
        name = free(wanted, self.taken)
        self.taken.add(name)
        return name

    def name_of(self, cell: Cell) -> str:
        """Return the entry of a variable."""
        if isinstance(cell.initial, list | dict):
            raise NotExpressibleError("/", f"the initial value of the variable {cell.name!r}", TARGET)
        if id(cell) not in self.cells:
            self.cells[id(cell)] = self.entry(cell.name)
        return self.cells[id(cell)]

    def text(self, part: Part, expression: str, around: bool = False) -> str:
        """Return an expression over the variables that a part sees as a script."""
        scope = part.around if around else part.scope
        names = {name: scope.cell(name) for name in parse_expression(expression).names}
        try:
            types = {self.name_of(cell): cell.type for cell in names.values()}
            known = {name: self.name_of(cell) for name, cell in names.items()}
            return script_of(expression, lambda name: types.get(name, "Any"), known, wide=True)
        except ValueError as error:
            raise self.refuse(part, f"`{expression}` ({error})") from error

    def begin(self, part: Part, cells: Iterable[Cell] = ()) -> list[str]:
        """Return assignments that give the variables of a part their initial values."""
        found = list(cells or (part.scope.cells.values() if part.declares else ()))
        return [f"{self.name_of(cell)} := {self.value(part, cell.initial)}" for cell in found if self.has_initial(cell)]

    def has_initial(self, cell: Cell) -> bool:
        """Tell whether a variable has an initial value; null is none."""
        return cell.initial is not UNSET and cell.initial is not None and not isinstance(cell.initial, list)

    def value(self, part: Part, value: Any) -> str:
        """Return a literal as a script."""
        if isinstance(value, bool | int | float | str):
            try:
                return script_of(repr(value), lambda name: "Any")
            except ValueError as error:
                raise self.refuse(part, f"the value {value!r} ({error})") from error
        raise self.refuse(part, f"the value {value!r} of a variable")

    # --- nodes ---

    def node(self, part: Part) -> Xml:
        """Return a part; it ends with its meaning, and `outcome` and `code` say the rest."""
        made = self.leaf(part) if isinstance(part.node, model.Leaf) else self.container(part)
        if part.node.precondition:
            asked = holds(self.text(part, part.node.precondition, around=True))
            asked.said["_onFailure"] = "outcome := 'failure'; code := 'precondition'"
            made = around("Sequence", asked, made)
            if part.meaning.get("failure") == "success":
                raise self.refuse(part, "a precondition whose failure means success")
        if part.node.doc:
            made.said["_description"] = part.node.doc
        return made

    def leaf(self, part: Part) -> Xml:
        """Return a leaf."""
        node, manifest = part.node, part.manifest
        assert isinstance(node, model.Leaf), "of leaves"
        assert manifest is not None, "resolved leaves have a manifest"
        well, badly = "outcome := 'success'; code := ''", "outcome := 'failure'"
        match node.node:
            case "flow/succeed":
                return Xml("AlwaysSuccess", {"_onSuccess": well})
            case "flow/fail":
                return Xml("AlwaysFailure", {"_onFailure": f"{badly}; code := '{node.with_.get('code', 'failed')}'"})
            case "flow/wait":
                return Xml("Sleep", {"msec": milliseconds(part, node.with_["seconds"]), "_onSuccess": well})
            case "flow/set" if node.out:
                target = self.name_of(part.scope.cell(node.out["value"]))
                return Xml(
                    "Script", {"code": f"{target} := {self.value(part, node.with_['value'])}", "_onSuccess": well}
                )
            case "flow/compute" if node.out:
                target = self.name_of(part.scope.cell(node.out["value"]))
                return Xml("Script", {"code": f"{target} := {self.computed(part, node)}", "_onSuccess": well})
        said: dict[str, str] = {}
        for name, value in node.with_.items():
            said[name] = self.literal(part, name, value, manifest.parameters[name].type)
        for port, variable in (*node.in_.items(), *node.out.items()):
            entry = f"{{{self.name_of(part.scope.cell(variable))}}}"
            if said.get(port, entry) != entry:
                raise self.refuse(part, f"{port!r}, which is more than one port or parameter,")
            said[port] = entry
        self.used[manifest.id] = manifest
        said |= (
            {"outcome": "{outcome}", "code": "{code}"}
            if tells(manifest)
            else {"_onSuccess": well, "_onFailure": f"{badly}; code := ''"}
        )
        if self.asked:
            said["preempt"] = f"{{{self.asked[-1]}}}"
        made = Xml(tag_of(manifest), {"name": part.path, **said})
        if {"name", "ID"} & {*node.with_, *node.in_, *node.out}:
            raise self.refuse(part, "a port or parameter called `name` or `ID`")
        if any(part.meaning.get(end) != meaning for end, meaning in manifest.outcomes.items()):
            return around("Sequence", around("ForceSuccess", made), self.verdict("outcome", part.meaning))
        return made

    def foreign(self, part: Part, node: model.Foreign) -> Xml:
        """Return a behaviour of py_trees as a leaf, to be written in C++."""
        outcomes = {name: self.literal(part, name, value) for name, value in node.args.items()}
        ends = {
            "_onSuccess": "outcome := 'success'; code := ''",
            "_onFailure": "outcome := 'failure'; code := 'foreign'",
        }
        name = node.behaviour.partition(":")[2].rpartition(".")[2]
        ports = {port: Parameter(type="Any") for port in node.args}
        face = Manifest(id=f"{GROUP}/{name}", doc=node.behaviour, implementation="", parameters=FrozenDict(ports))
        self.used[face.id] = face
        return Xml(name, {"name": part.path, **outcomes, **ends})

    def literal(self, part: Part, name: str, value: Any, kind: str = "Any") -> str:
        """Return the text of an attribute."""
        try:
            return str(value) if kind == "Any" and type(value) in (int, float) else attribute_text(value, kind)
        except ValueError as error:
            raise self.refuse(part, f"`{name}` ({error})") from error

    def control(self, part: Part) -> Xml:
        """Return a control node under its own name, with the ports of the leaf that decides."""
        decides, *others = part.children
        if decides.manifest is None or part.exits or decides.manifest.id in ("btcpp/OnHalted", "btcpp/Switch"):
            raise self.refuse(part, "a control whose ends are labelled, or whose leaf has no element")
        made = self.leaf(decides)
        made.children = [self.node(child) for child in others]
        return made

    def computed(self, part: Part, node: model.Leaf) -> str:
        """Return what `flow/compute` computes."""
        names = {letter: part.scope.cell(variable) for letter, variable in node.in_.items()}
        types = {self.name_of(cell): cell.type for cell in names.values()}
        known = {letter: self.name_of(cell) for letter, cell in names.items()}
        try:
            return script_of(node.with_["expression"], lambda name: types.get(name, "Any"), known, wide=True)
        except ValueError as error:
            raise self.refuse(part, f"`{node.with_['expression']}` ({error})") from error

    def verdict(self, entry: str, meaning: Any) -> Xml:
        """Return what succeeds where a label means success."""
        well = [label for label, means in meaning.items() if means == "success"]
        made = holds(any_of(f"{entry} == '{label}'" for label in well))
        made.said["_onSuccess"] = "code := ''"
        return made

    def container(self, part: Part) -> Xml:
        """Return a container with its variables begun anew."""
        node = part.node
        match node:
            case model.Sequence() | model.Fallback():
                made = self.series(part, node)
            case model.Switch():
                made = self.switch(part, node)
            case RoundRobin():
                made = self.turns(part)
            case model.Parallel():
                made = parallel(self, part, node)
            case model.Guard():
                failed = "outcome := 'failure'; code := 'guard'"
                asked = Xml("ScriptCondition", {"code": self.text(part, node.if_), "_onFailure": failed})
                made = around("ReactiveSequence", asked, self.ending(part, part.children[0]))
            case model.Timeout(child_first=False, seconds=seconds):
                made = self.timeout(part, seconds)
            case model.Invert() | model.Force():
                made = self.ending(part, part.children[0])
            case model.ForEach():
                made = self.each(part, node)
            case model.Foreign():
                made = self.foreign(part, node)
            case model.Subtask():
                made = self.subtask(part, node)
            case Control():
                made = self.control(part)
            case _ if isinstance(node, _LOOPS):
                made = self.loop(part)
            case _:
                raise self.refuse(part, f"a {getattr(node, 'kind', 'leaf')}")
        first = self.begin(part) if not isinstance(node, model.Subtask) else []
        return around("Sequence", script(*first), made) if first else made

    def target(self, part: Part, child: Part, natural: dict[str, str]) -> str:
        """Return the label with which a container ends after a child, as an expression over `outcome` and `code`.

        Args:
            natural: meaning of the child's end -> label, or '' to go on.
        """
        ways = list(leads(part.exits, child))
        ways += [(f"outcome == '{label}'", f"'{natural[means]}'") for label, means in child.meaning.items()]
        return chosen(ways, "''")

    def ended(self, part: Part, child: Part, done: str, natural: dict[str, str], *more: str) -> list[Xml]:
        """Return a child, run to its end, and what notes where that leads."""
        return [
            around("ForceSuccess", self.node(child)),
            script(f"{done} := {self.target(part, child, natural)}", *more),
        ]

    def finish(self, part: Part, done: str, body: Xml, first: Sequence[str] = ()) -> Xml:
        """Return a body that notes an end, and the end that it has noted."""
        start = [script(*first)] if first else []
        return around(
            "Sequence",
            *start,
            around("ForceSuccess", body),
            script(f"outcome := {done}"),
            self.verdict(done, part.meaning),
        )

    def series(self, part: Part, node: Any) -> Xml:
        """Return a sequence or fallback."""
        onward = node.onward
        if not part.children:
            return around(
                "Sequence", script(f"outcome := '{onward}'", "code := ''"), self.verdict("outcome", part.meaning)
            )
        done, steps = self.entry("done"), []
        natural = {"success": "success", "failure": "failure"}
        for child in part.children:
            last = child is part.children[-1]
            way = natural if last else {**natural, onward: ""}
            steps.append(around("Sequence", *self.ended(part, child, done, way), holds(f"{done} == ''")))
        return self.finish(part, done, around("Sequence" if node.memory else "ReactiveSequence", *steps))

    def ending(self, part: Part, child: Part) -> Xml:
        """Return the one child of a decorator or chooser, after which it ends."""
        done, node = self.entry("done"), part.node
        natural, more = {"success": "success", "failure": "failure"}, ""
        if isinstance(node, model.Invert):
            natural = {"success": "failure", "failure": "success"}
            more = f"code := ({self.exited(part, child)} ? code : '')"
        elif isinstance(node, model.Force):
            natural = dict.fromkeys(natural, node.as_)
        note = script(f"{done} := {self.target(part, child, natural)}", *([more] if more else []), f"outcome := {done}")
        return around("Sequence", around("ForceSuccess", self.node(child)), note, self.verdict(done, part.meaning))

    def exited(self, part: Part, child: Part) -> str:
        """Return whether an exit was taken."""
        return any_of(condition for condition, _ in leads(part.exits, child))

    def chosen_child(self, part: Part, entry: str, ways: Sequence[Xml]) -> Xml:
        """Return a Switch over the number of a child; more than six are in a Switch of its own."""
        if len(ways) == 1:
            return ways[0]
        first, rest = list(ways[:6]), Xml("AlwaysFailure")
        if more := ways[6:]:
            inner = self.entry("at")
            rest = around("ReactiveSequence", script(f"{inner} := {entry} - 6"), self.chosen_child(part, inner, more))
        said = {"variable": f"{{{entry}}}", **{f"case_{i}": str(i) for i in range(1, len(first) + 1)}}
        return Xml(f"Switch{len(first)}", said, [*first, rest])

    def switch(self, part: Part, node: model.Switch) -> Xml:
        """Return a switch; which child it is stands in an entry."""
        at, names = self.entry("at"), [child.name for child in part.children]
        ways = []
        for child, literal in node.literals():
            tree = ast.unparse(ast.Compare(parse_expression(node.on_value).tree, [ast.Eq()], [ast.Constant(literal)]))
            ways.append((self.text(part, tree), str(names.index(child) + 1 if child in names else 0)))
        other = str(names.index(node.default) + 1) if node.default in names else str(len(names) + 1)
        none = Xml("AlwaysFailure", {"_onFailure": "outcome := 'failure'; code := 'no_case'"})
        children = [*(self.ending(part, child) for child in part.children), none]
        pick = script(f"{at} := {chosen(ways, other)}")
        return around("Sequence" if node.memory else "ReactiveSequence", pick, self.chosen_child(part, at, children))

    def turns(self, part: Part) -> Xml:
        """Return a round robin; whose turn it is stands in an entry, which begins with the task."""
        turn, at, size = self.entry("turn"), self.entry("at"), len(part.children)
        self.first.append(f"{turn} := 0")
        pick = script(f"{at} := {turn} + 1", f"{turn} := ({turn} == {size - 1} ? 0 : {turn} + 1)")
        return around("Sequence", pick, self.chosen_child(part, at, [self.ending(part, c) for c in part.children]))

    def timeout(self, part: Part, seconds: float) -> Xml:
        """Return a timeout; an entry says whether the child has ended."""
        over = self.entry("over")
        inner = self.ending(part, part.children[0])
        inner.said["_post"] = f"{over} := 1"
        late = f"outcome := ({over} == 1 ? outcome : 'failure'); code := ({over} == 1 ? code : 'time_out')"
        limit = Xml("Timeout", {"msec": milliseconds(part, seconds), "_onFailure": late}, [inner])
        return around("Sequence", script(f"{over} := 0"), limit)

    def each(self, part: Part, node: model.ForEach) -> Xml:
        """Return a loop over a literal list that nobody writes."""
        cell = part.scope.cell(node.items)
        if not isinstance(cell.initial, list) or not all(type(item) is int for item in cell.initial):
            raise self.refuse(part, "a for_each over anything but a literal list of whole numbers")
        item = self.name_of(part.scope.cells[node.item])
        queue = ";".join(map(str, cell.initial))
        if not queue:
            return Xml("AlwaysSuccess", {"_onSuccess": "outcome := 'success'; code := ''"})
        done, child = self.entry("done"), part.children[0]
        body = around(
            "Sequence", *self.ended(part, child, done, {"success": "", "failure": "failure"}), holds(f"{done} == ''")
        )
        loop = around("LoopInt", body, queue=queue, value=f"{{{item}}}")
        end = f"{done} := ({done} == '' ? 'success' : {done})"
        return self.finish(
            part, done, around("Sequence", around("ForceSuccess", loop), script(end)), [f"{done} := ''", "code := ''"]
        )

    def loop(self, part: Part) -> Xml:
        """Return what goes on with the next tick after each child: a machine, attempts, passes."""
        node, done = part.node, self.entry("done")
        first, before = [f"{done} := ''"], []
        if isinstance(node, model.StateMachine):
            at, names = self.entry("at"), [child.name for child in part.children]
            first.append(f"{at} := {names.index(node.initial) + 1}")
            ways = [self.step(part, child, done, at, names) for child in part.children]
            body = [self.chosen_child(part, at, ways)]
        else:
            count = self.entry("count")
            first.append(f"{count} := 0")
            child, times = part.children[0], getattr(node, "times", None)
            again, stop = ("failure", "success") if isinstance(node, model.Retry) else ("success", "failure")
            natural = {again: "", stop: stop}
            more = []
            if isinstance(node, model.Loop):
                if node.while_:
                    before.append(f"{done} := ({self.text(part, node.while_)} ? '' : 'success')")
                    before.append(f"code := ({done} == '' ? code : '')")
                if times is not None:
                    over = f"{done} == '' && {count} >= {times}"
                    before.append(f"code := (({over}) ? 'loop_limit' : code)")
                    before.append(f"{done} := (({over}) ? 'failure' : {done})")
            elif times is not None:
                more.append(f"{done} := (({done} == '' && {count} >= {times}) ? '{again}' : {done})")
            body = self.ended(part, child, done, natural, *more)
            body.insert(0, script(f"{count} := {count} + 1"))
            if before:
                body = [script(*before), holds(f"{done} == ''"), *body]
        loop = around("KeepRunningUntilFailure", around("Sequence", *body, holds(f"{done} == ''")))
        return self.finish(part, done, loop, first)

    def step(self, part: Part, child: Part, done: str, at: str, names: list[str]) -> Xml:
        """Return a state, and what notes where its end leads."""
        to_state = [
            (asked, str(names.index(label) + 1)) for asked, label in leads(part.edges, child, "") if label in names
        ]
        to_end = [
            (asked, f"'{label}'" if label not in names else "''") for asked, label in leads(part.edges, child, "")
        ]
        note = script(f"{done} := " + chosen(to_end, "''"), f"{at} := {chosen(to_state, at)}")
        return around("Sequence", around("ForceSuccess", self.node(child)), note)

    def subtask(self, part: Part, node: model.Subtask) -> Xml:
        """Return the root of another file in its place."""
        task, root = part.scope.cells, part.children[0]
        given = [f"{self.name_of(task[port])} := {self.value(part, value)}" for port, value in node.with_.items()]
        outside = part.outside
        assert outside is not None, "of subtasks"
        copied = [f"{self.name_of(task[p])} := {self.name_of(outside.cell(v))}" for p, v in node.in_.items()]
        others = [cell for name, cell in task.items() if name not in node.with_ and name not in node.in_]
        first = [*self.begin(part, others), *copied, *given] if others else [*copied, *given]
        done = self.entry("done")
        body = around("Sequence", *self.ended(part, root, done, {"success": "success", "failure": "failure"}))
        for port, variable in node.out.items():  # copied where it was written
            inner, outer = task[port], self.name_of(outside.cell(variable))
            if inner.type != "int":
                raise self.refuse(part, f"the output {port!r} of a subtask, of type {inner.type}")
            if port not in node.in_ and port not in node.with_ and not self.has_initial(inner):
                first.append(f"{self.name_of(inner)} := {_UNWRITTEN}")
            name = self.name_of(inner)
            told = around("Sequence", holds(f"{name} != {_UNWRITTEN}"), script(f"{outer} := {name}"))
            body.children.append(around("ForceSuccess", told))
        return self.finish(part, done, body, first or [f"{done} := ''"])


def document(resolved: Resolved, used: dict[str, Manifest]) -> Xml:
    """Return what stands in the main tree of a task.

    Raises:
        NotExpressibleError: BT.CPP has no words for a part of it.
    """
    work, root = Lowering(used), resolved.root
    if resolved.task.outputs:
        raise NotExpressibleError("/", "outputs of a task", TARGET)
    body = work.node(root)
    cells = [cell for cell in resolved.scopes[""].cells.values() if not isinstance(cell.initial, list | dict)]
    first = ["outcome := ''", "code := ''", *work.first, *(work.begin(root, cells) if cells else ())]
    ends = work.entry("done")
    table = [(lab, why, to) for (_, lab, why), to in resolved.ends]
    meaning = resolved.task.outcomes
    changed = any(meaning[to] != root.meaning.get(lab) or to != lab for lab, why, to in table)
    if changed:
        table.sort(key=lambda each: each[1] is None)
        ways = [(labelled(said_of(lab, why), "outcome", "code"), f"'{to}'") for lab, why, to in table]
        note = script(f"{ends} := {chosen(ways, 'outcome')}", f"outcome := {ends}")
        body = around("Sequence", around("ForceSuccess", body), note, work.verdict(ends, meaning))
    return around("Sequence", script(*first), body)
