"""A container that was found -> a task: state machines of leaves, a parallel for a Concurrence that is one."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Mapping
from typing import Any

from grip_bt.catalog import Catalog
from grip_bt.graph import FrozenDict, Leaf, Parallel, StateMachine, Task, Variable, children_of
from grip_bt.graph.model import AnyNode, Meaning
from grip_bt.nodes.smach_leaf import task_name
from grip_bt.validation import validate
from grip_bt.validation.dataflow import DataFlow
from grip_bt.validation.survey import Survey

from .concurrence import Plan, RefusedError, plan_of
from .found import Added, Found, FoundContainer
from .iteration import iteration_of
from .keys import Keys, Variables
from .leaves import Leaves
from .meanings import meaning_of
from .sharing import Sharing, copied_in

Ends = Mapping[str, str]
"""Outcome of a node -> the outcome of SMACH that it stands for."""


class TaskMaker:
    """Makes the task of one outermost container."""

    def __init__(self, root: FoundContainer, name: str, leaves: Leaves):
        self.root, self.name, self.leaves = root, name, leaves
        self.variables, self.sharing = Variables(), Sharing()
        self.own: set[tuple[FoundContainer, str]] = set()

    def make(self) -> Task | None:
        """Return the task; None when the container can't be imported, with the reason among its problems."""
        specs = dict(self.leaves.specs)
        try:
            node, ends = self._root()
            self.own = self.sharing.copied_out(self._initial())
            if self.own:  # again, now that it is known which keys have to be copied
                self.variables, self.sharing, self.leaves.specs = Variables(), Sharing(), specs
                node, ends = self._root()
        except RefusedError as error:
            if self.root.verdict != "failed":
                self.root.problem("failed", str(error))
            return None
        self.sharing.check(self._initial())
        outcomes = {task_name(o): meaning_of(o) for o in self.root.outcomes or ()}
        on = {here: task_name(there) for here, there in ends.items() if here != task_name(there)}
        node = node.model_copy(update={"on": FrozenDict(on)})
        return self._checked(node, outcomes)

    def _root(self) -> tuple[Any, Ends]:
        keys = Keys(self.variables, self.name)
        for key in self.root.input_keys:
            keys(key)
        made: tuple[Any, Ends] = self.container(self.root, keys, None)
        return made

    def _initial(self) -> set[str]:
        return {*self.variables.values, *self.variables.first}

    # --- nodes ---

    def container(self, found: FoundContainer, keys: Keys, meaning: Mapping[str, Meaning] | None) -> Any:
        """Return a container as a node, and what its outcomes stand for.

        Raises:
            RefusedError: it has no equal.
        """
        check(found)
        keys.begin(found)
        if found.kind == "Concurrence":
            if meaning is not None:
                raise RefusedError("it is a child of another Concurrence")
            return self._parallel(found, keys, plan_of(found))
        ends = {task_name(o): o for o in found.outcomes or ()}
        means = {here: (meaning or {}).get(there, meaning_of(there)) for here, there in ends.items()}
        if wrong := [o for o in ("success", "failure") if o in means and means[o] != o]:
            raise RefusedError(f"its outcome {wrong[0]!r} would have to mean the opposite")
        if found.kind == "Iterator":
            return self._iterator(found, keys, means), ends
        names = self._labels(found)
        children = {}
        for label, added in found.added.items():
            node, child_ends = self.child(found, added, keys, None)
            on = {here: self._target(found, added, there, names) for here, there in child_ends.items()}
            children[names[label]] = node.model_copy(update={"on": FrozenDict(on)})
        initial = names[found.initial or ""]
        machine = StateMachine(
            kind="state_machine", initial=initial, outcomes=means, children=children, x=_source(found)
        )
        return machine, ends

    def _iterator(self, found: FoundContainer, keys: Keys, means: Mapping[str, Meaning]) -> StateMachine:
        plan = iteration_of(found)
        spec = self.leaves.next_item()
        added = next(iter(found.added.values()))
        name = task_name(added.label)
        name += "_" * (name in means or name == "next")
        first = "next" if "next" not in means else "next_"
        node, ends = self.child(found, added, keys, None, raw=True)
        position = self.variables.new("position", task_name(found.cls))
        item = keys(plan.label)
        self.sharing.wrote({item})
        on = {here: first if there in plan.loops else task_name(plan.final[there]) for here, there in ends.items()}
        step = Leaf(
            node=spec.manifest.id,
            with_={"items": plan.items},
            in_={"position": position},
            out={"position": position, "item": item},
            on={"item": name, "exhausted": task_name(plan.exhausted)},
        )
        return StateMachine(
            kind="state_machine",
            initial=first,
            outcomes=dict(means),
            data={position: Variable(type="int", value=0)},
            children={first: step, name: node.model_copy(update={"on": FrozenDict(on)})},
            x=_source(found),
        )

    def _parallel(self, found: FoundContainer, keys: Keys, plan: Plan) -> tuple[Parallel, Ends]:
        children, exits = {}, {}
        for label in plan.order:
            added = found.added[label]
            wanted = plan.wanted.get(label)
            meaning: dict[str, Meaning] = {
                o: "success" if wanted in (None, o) else "failure" for o in self.outcomes(added)
            }
            node, ends = self.child(found, added, keys, meaning)
            children[task_name(label)] = node
            back = {there: here for here, there in ends.items()}
            for (child, outcome), end in plan.exits.items():
                if child == label and outcome in back:
                    exits[f"{task_name(label)}.{back[outcome]}"] = end
        own = {end: meaning_of(plan.ends[end]) for end in plan.exits.values()}
        node = Parallel(kind="parallel", cancel="join", children=children, exits=exits, outcomes=own, x=_source(found))
        return node, plan.ends

    def child(
        self, found: FoundContainer, added: Added, keys: Keys, meaning: Mapping[str, Meaning] | None, raw: bool = False
    ) -> tuple[AnyNode, Ends]:
        """Return one child as a node."""
        state = added.state
        for each in state.problems if not isinstance(state, FoundContainer) else ():
            found.problem(each.verdict, each.text, each.span)
        remapping = {} if raw else added.remapping
        if not isinstance(state, FoundContainer):
            return self._leaf(found, added, keys, remapping, meaning)
        shared = {k: keys(remapping.get(k, k)) for k in (*state.input_keys, *state.output_keys)}
        copied = {k: shared.pop(k) for k in copied_in(state) if shared[k] not in self.variables.first}
        before = dict(self.variables.names), dict(self.leaves.specs)
        out = {k: shared.pop(k) for k in state.output_keys if (state, k) in self.own and k in shared}
        writes = list(self.sharing.writes)
        try:
            self.sharing.chain.append(state)
            inner = Keys(self.variables, task_name(added.label), shared)
            node, ends = self.container(state, inner, meaning)
            self.sharing.shared.append((state, shared))
            node = self._left(node, out, inner) if out else node
            return (self._entered(node, copied, inner) if copied else node), ends
        except RefusedError as error:
            self.sharing.writes = writes
            self.variables.names, self.leaves.specs = before
            runs = bool(self.leaves.source(state))
            state.problems = [p for p in state.problems if p.verdict != "failed"] if runs else state.problems
            as_leaf = "it is one leaf, which runs it as it is" if runs else "it isn't in the task"
            state.problem("partial" if runs else "failed", f"{as_leaf}: {error}")
        finally:
            self.sharing.chain.pop()
        return self._leaf(found, added, keys, remapping, meaning)

    def _entered(self, node: StateMachine, copied: Mapping[str, str], inner: Keys) -> StateMachine:
        """Put a state first that copies keys in, as SMACH does."""
        name = "enter"
        while name in node.children or name in node.outcomes:
            name += "_"
        step = Leaf(
            node=self.leaves.copy(list(copied)).manifest.id,
            in_=dict(copied),
            out={key: inner(key) for key in copied},
            on={"done": node.initial},
        )
        return node.model_copy(update={"initial": name, "children": FrozenDict({name: step, **node.children})})

    def _left(self, node: StateMachine, out: Mapping[str, str], inner: Keys) -> StateMachine:
        """Put a state before each outcome that copies keys out, as SMACH does."""
        self.sharing.wrote_outside(set(out.values()))
        taken = {*node.children, *node.outcomes}
        names: dict[str, str] = {}
        for outcome in node.outcomes:
            name = f"leave {outcome}"
            while name in taken:
                name += "_"
            names[outcome] = name
        children = {
            label: child.model_copy(update={"on": FrozenDict({k: names.get(t, t) for k, t in child.on.items()})})
            for label, child in node.children.items()
        }
        used = {target for child in children.values() for target in child.on.values()}
        spec = self.leaves.copy(list(out))
        for outcome, name in names.items():
            if name in used:
                bound = {"in_": {key: inner(key) for key in out}, "out": dict(out)}
                children[name] = Leaf(node=spec.manifest.id, on={"done": outcome}, **bound)
        return node.model_copy(update={"children": FrozenDict(children)})

    def _leaf(
        self,
        found: FoundContainer,
        added: Added,
        keys: Keys,
        remapping: Mapping[str, str],
        meaning: Mapping[str, Meaning] | None,
    ) -> tuple[Leaf, Ends]:
        state, outcomes = added.state, self.outcomes(added)
        inputs, outputs = state.input_keys, state.output_keys
        if not state.kind:
            inputs = outputs = list(remapping)
        bound = {key: keys(remapping.get(key, key)) for key in (*inputs, *outputs)}
        first = {k: (v, text) for k in inputs if (v := bound[k]) in self.variables.first and (text := self._first(v))}
        self.sharing.wrote({bound[key] for key in outputs})
        spec = self.leaves.add(state, added.label, outcomes, (inputs, outputs), first)
        if not spec.source:
            why = state.why or f"`{state.cls}` can't be made outside of what builds it"
            found.problem("partial", f"{why}; say in leaves.py how {spec.cls} is made", added.span)
        ends = {task_name(o): o for o in outcomes}
        usual = spec.manifest.outcomes
        means = {h: m for h, t in ends.items() if (m := (meaning or {}).get(t, usual[h])) != usual[h]}
        renamed = {here: there for here, there in ends.items() if here != there}
        leaf = Leaf(
            node=spec.manifest.id,
            in_={key: bound[key] for key in inputs},
            out={key: bound[key] for key in outputs},
            meaning=means,
            x={"x-source": str(added.span), **({"x-outcomes": renamed} if renamed else {})},
        )
        return leaf, ends

    def _first(self, variable: str) -> str:
        expression, where = self.variables.first[variable]
        if isinstance(where, FoundContainer):
            assert isinstance(expression, ast.Constant), "a key of that container"
            live = self.leaves.live(where)
            return f"{live}.userdata[{expression.value!r}]" if live else ""
        return self.leaves.unparsed(expression, where)

    # --- edges ---

    def outcomes(self, added: Added) -> list[str]:
        """Return a state's outcomes; where nothing is known of them, those that lead somewhere."""
        state = added.state
        if state.outcomes:
            return state.outcomes
        known = [o for o in (*added.transitions, *added.connectors)]
        if not known:
            raise RefusedError(f"nothing is known of the outcomes of {added.label!r} ({state.cls})")
        if not state.problems:
            state.problem(
                "partial",
                f"the outcomes of {state.cls} are taken from its transitions, since its class isn't here",
            )
        return list(dict.fromkeys(known))

    def _target(self, found: FoundContainer, added: Added, outcome: str, names: Mapping[str, str]) -> str:
        target = added.transitions.get(outcome)
        if target is not None and target in names:
            return names[target]
        target = target or outcome
        if target not in (found.outcomes or ()):
            raise RefusedError(f"{outcome!r} of {added.label!r} leads to {target!r}, which isn't there")
        return task_name(target)

    def _labels(self, found: FoundContainer) -> dict[str, str]:
        """Return the states' names; one that is also an outcome gets another, since SMACH prefers the state."""
        used = {task_name(o) for o in found.outcomes or ()}
        names: dict[str, str] = {}
        for label in found.added:
            name = task_name(label)
            while name in used:
                name += "_"
            used.add(name)
            names[label] = name
        return names

    # --- the whole ---

    def _checked(self, node: AnyNode, outcomes: Mapping[str, Meaning]) -> Task:
        catalog = Catalog.builtin().with_manifests(spec.manifest for spec in self.leaves.specs.values())
        task = self._task(node, outcomes, set())
        missing = set(DataFlow(Survey(task, catalog, None)).missing.values()) | set(self.variables.first)
        task = self._task(_marked(node, missing), outcomes, missing)
        for issue in validate(task, catalog).issues:
            if issue.severity == "error":
                self.root.problem("partial", f"`grip check`: {issue.path}: {issue.message}")
        return task

    def _task(self, node: AnyNode, outcomes: Mapping[str, Meaning], missing: set[str]) -> Task:
        data = self.variables.declared(missing)
        local = {name for each in _walk(node) for name in getattr(each, "data", {})}
        return Task(
            grip=1,
            name=self.name,
            doc=f"Imported from {self.root.span.file.name}.",
            outcomes=dict(outcomes),
            data={name: declared for name, declared in data.items() if name not in local},
            root=node,
        )


def check(found: FoundContainer) -> None:
    """Refuse what no machine can be made of.

    Raises:
        RefusedError: the container wasn't read well enough, or SMACH would refuse it too.
    """
    if failed := [p for p in found.problems if p.verdict == "failed"]:
        raise RefusedError(failed[0].text)
    if not found.outcomes:
        raise RefusedError("its outcomes aren't known")
    if not found.added:
        raise RefusedError("nothing is added to it")
    for label, added in found.added.items():
        known = added.state.outcomes
        if known and (wrong := sorted(set(added.transitions) - set(known))):
            raise RefusedError(f"{label!r} has transitions for {wrong}, but {added.state.cls} ends with {known}")
    if found.kind in ("StateMachine", "Sequence") and found.initial not in found.added:
        raise RefusedError(f"its initial state {found.initial!r} isn't there")


def _marked(node: AnyNode, missing: set[str]) -> AnyNode:
    """Tell every leaf which of its inputs may be unwritten."""
    if isinstance(node, Leaf):
        unwritten = [port for port, variable in node.in_.items() if variable in missing and port != "position"]
        return node.model_copy(update={"with_": FrozenDict({"unwritten": unwritten})}) if unwritten else node
    children = {name: _marked(child, missing) for name, child in children_of(node).items()}
    return node.model_copy(update={"children": FrozenDict(children)})


def _walk(node: AnyNode) -> Iterable[AnyNode]:
    yield node
    for child in children_of(node).values():
        yield from _walk(child)


def _source(found: Found) -> dict[str, Any]:
    return {"x-source": str(found.span)}
