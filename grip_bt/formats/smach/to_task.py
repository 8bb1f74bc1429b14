"""A container that was found -> a task: state machines of leaves, a parallel for a Concurrence that is one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from grip_bt.formats.names import free
from grip_bt.nodes.smach_leaf import task_name
from grip_bt.task import FrozenDict, Leaf, Parallel, StateMachine, Task, Variable, model
from grip_bt.task.catalog import Catalog
from grip_bt.task.model import AnyNode, Meaning, ParallelRule
from grip_bt.task.validation import validate

from . import userdata
from .found import Child, ContainerInfo
from .leaves import Leaves
from .userdata import Keys, RefusedError, Rules, Variables

COPIED = "is a copy in SMACH"
ONE_LEAF = "imported as one leaf that runs the original container"
Ends = Mapping[str, str]
"""Outcome of a node -> the outcome of SMACH that it stands for."""


class TaskMaker:
    """Makes the task of one outermost container; without equivalent it may become a task of one leaf, which runs it."""

    may_be_one_leaf = True

    def __init__(self, root: ContainerInfo, name: str, leaves: Leaves):
        self.root, self.name, self.leaves = root, name, leaves
        self.variables = Variables()

    def make(self) -> Task | None:
        """Return the task; None when the container can't be imported, with the reason among its issues."""
        specs = dict(self.leaves.specs)
        one_leaf = self.may_be_one_leaf and self.root.outcomes and self.leaves.source(self.root)
        own = self.root.settings.get("overridden", ())
        for method in () if one_leaf else own:
            self.root.problem("partial", f"its class has a `{method}` of its own, which the task doesn't call")
        try:
            if own and one_leaf:
                raise RefusedError(f"its class has a `{own[0]}` of its own")
            keys = Keys(self.variables, self.name)
            for key in self.root.input_keys:
                keys(key)
            node, ends = self.container(self.root, keys)
        except RefusedError as error:
            if self.root.verdict == "failed" or not one_leaf:
                if self.root.verdict != "failed":
                    self.root.problem("failed", str(error))
                return None
            self.root.problem("note", f"{ONE_LEAF}: {error}")
            self.variables, self.leaves.specs = Variables(), specs
            whole = Child(label=self.name, state=self.root, transitions={}, remapping={}, span=self.root.span)
            node, ends = self._leaf(self.root, whole, Keys(self.variables, self.name), {})
        outcomes = userdata.meanings(self.root, self.leaves.meanings)
        if guessed := self.leaves.meanings.guessed(self.root.outcomes or ()):
            said = "is taken for success, as no outcome has that name; --success NAME says otherwise"
            self.root.problem("note", f"`{guessed}` {said}")
        on = {here: task_name(there) for here, there in ends.items() if here != task_name(there)}
        node = node.model_copy(update={"on": FrozenDict(on)})
        return self._checked(node, outcomes)

    def container(self, found: ContainerInfo, keys: Keys) -> tuple[Any, Ends]:
        """Return a container as a node, and what its outcomes stand for; refuse one that has no equivalent."""
        userdata.check(found)
        keys.begin(found)
        if found.kind == "Concurrence":
            return self._parallel(found, keys, *userdata.parallel_rules(found))
        ends = {task_name(o): o for o in found.outcomes or ()}
        if found.kind == "Iterator":
            return self._iterator(found, keys, userdata.meanings(found, self.leaves.meanings)), ends
        names: dict[str, str] = {}
        for label in found.added:  # one that is also an outcome gets another name, since SMACH prefers the state
            names[label] = free(task_name(label), {*ends, *names.values()})
        children: dict[str, AnyNode] = {}
        for label, added in found.added.items():
            node, child_ends = self.child(found, added, keys)
            on = {here: self._target(found, added, there, names) for here, there in child_ends.items()}
            children[names[label]] = node.model_copy(update={"on": FrozenDict(on)})
        machine = StateMachine(
            kind="state_machine",
            initial=names[found.initial or ""],
            outcomes=userdata.meanings(found, self.leaves.meanings),
            children=children,
            x=userdata.source_of(found),
        )
        return machine, ends

    def _iterator(self, found: ContainerInfo, keys: Keys, means: Mapping[str, Meaning]) -> StateMachine:
        plan = userdata.iteration_of(found)
        added = next(iter(found.added.values()))
        name = free(task_name(added.label), {*means, "next"})
        node, ends = self.child(found, added, keys, raw=True)
        position = self.variables.new("position", task_name(found.cls))
        item = keys(plan.label)
        on, steps = {here: task_name(plan.final[there]) for here, there in ends.items() if there in plan.final}, {}
        for number, (target, loops) in enumerate(plan.interrupted.items() or [(plan.exhausted, [])]):
            step = free("next" if not number else f"next {number + 1}", means)
            on |= {here: step for here, there in ends.items() if there in loops}
            known = target in (found.outcomes or ())
            steps[step] = Leaf(
                node="smach/next_item",
                with_={"items": plan.items} if known else {"items": plan.items, "leaves_by": target},
                in_={"position": position},
                out={"position": position, "item": item},
                on={
                    "item": name,
                    "exhausted": task_name(plan.exhausted),
                    "preempted": task_name(target if known else plan.exhausted),
                },
            )
        return StateMachine(
            kind="state_machine",
            initial=next(iter(steps)),
            outcomes=dict(means),
            data={position: Variable(type="int", value=0)},
            children={**steps, name: node.model_copy(update={"on": FrozenDict(on)})},
            x=userdata.source_of(found),
        )

    def _parallel(self, found: ContainerInfo, keys: Keys, given: Rules, default: str) -> tuple[Parallel, Ends]:
        children: dict[str, AnyNode] = {}
        ends_of: dict[str, Ends] = {}
        for label, added in found.added.items():
            children[task_name(label)], ends_of[label] = self.child(found, added, keys)
        own, labels = userdata.labelled(found, default, self.leaves.meanings)
        ends = {"success": default, "failure": default} | {label: o for o, label in labels.items()}
        asked = free("asked", children)
        allowed = "preempted" in labels
        children[asked] = Leaf(node="smach/preempt_obeyed", with_={} if allowed else {"allowed": False})
        rules = [ParallelRule(when={asked: "preempted"}, then=labels["preempted"])] if allowed else []
        for outcome, wanted in given:
            by_child = {task_name(c): [h for h, there in ends_of[c].items() if there == o] for c, o in wanted.items()}
            if all(by_child.values()):  # what a state never ends with never holds
                when = {c: w[0] if len(w) == 1 else w for c, w in by_child.items()}
                rules.append(ParallelRule(when=when, then=labels[outcome]))
        rules.append(ParallelRule(then=labels[default]))
        node = Parallel(
            kind="parallel", cancel="join", children=children, rules=rules, outcomes=own, x=userdata.source_of(found)
        )
        return node, ends

    def child(self, found: ContainerInfo, added: Child, keys: Keys, raw: bool = False) -> tuple[AnyNode, Ends]:
        """Return one child as a node."""
        state, remapping = added.state, {} if raw else added.remapping
        if not isinstance(state, ContainerInfo):
            found.issues += [issue for issue in state.issues if issue not in found.issues]
            return self._leaf(found, added, keys, remapping)
        shared = {k: keys(remapping.get(k, k)) for k in (*state.input_keys, *state.output_keys)}
        own = userdata.private_keys(found, added, shared)
        for key in (k for k in state.input_keys if k in own and shared[k] in self.variables.first):
            own.discard(key)  # what a task can't hold isn't there to be copied before a leaf asks for it
            state.problem("partial", f"userdata `{key}` {COPIED}; the task has one variable, `{shared[key]}`")
        copied, out = ({k: shared[k] for k in ks if k in own} for ks in (state.input_keys, state.output_keys))
        before = dict(self.variables.names), dict(self.leaves.specs)
        try:
            inner = Keys(self.variables, task_name(added.label), {k: v for k, v in shared.items() if k not in own})
            node, ends = self.container(state, inner)
            if own and not isinstance(node, StateMachine):
                on = {here: task_name(there) for here, there in ends.items()}
                node = userdata.as_machine(node, on, userdata.meanings(state, self.leaves.meanings))
                ends = {task_name(o): o for o in state.outcomes or ()}
            if out:
                node = userdata.copy_out_last(node, out, inner, self.leaves)
            return (userdata.copy_in_first(node, copied, inner, self.leaves) if copied else node), ends
        except RefusedError as error:
            self.variables.names, self.leaves.specs = before
            runs = bool(self.leaves.source(state))
            for each in state.within() if runs else ():  # SMACH itself copies, and refuses what it comes to
                each.issues = [i for i in each.issues if i.severity != "error" and COPIED not in i.message]
            as_leaf = ONE_LEAF if runs else "left out of the task"
            state.problem("note" if runs else "failed", f"{as_leaf}: {error}")
        return self._leaf(found, added, keys, remapping)

    def _leaf(self, found: ContainerInfo, added: Child, keys: Keys, remapping: Mapping[str, str]) -> tuple[Leaf, Ends]:
        state, outcomes = added.state, added.state.outcomes
        if not outcomes:
            raise RefusedError(f"nothing is known of the outcomes of {added.label!r} ({state.cls})")
        inputs, outputs = state.input_keys, state.output_keys
        if not state.kind:
            inputs = outputs = list(remapping)
        bound = {key: keys(remapping.get(key, key)) for key in (*inputs, *outputs)}
        first = {k: (v, text) for k in inputs if (v := bound[k]) in self.variables.first and (text := self._first(v))}
        spec = self.leaves.add(state, added.label, outcomes, (inputs, outputs), first)
        ends = {task_name(o): o for o in outcomes}
        renamed = {here: there for here, there in ends.items() if here != there}
        leaf = Leaf(
            node=spec.manifest.id,
            in_={key: bound[key] for key in inputs},
            out={key: bound[key] for key in outputs},
            x={"x-source": str(added.span), **({"x-outcomes": renamed} if renamed else {})},
        )
        return leaf, ends

    def _first(self, variable: str) -> str:
        key, where = self.variables.first[variable]
        live = self.leaves.source(where)
        return f"{live}.userdata[{key!r}]" if live else ""

    def _target(self, found: ContainerInfo, added: Child, outcome: str, names: Mapping[str, str]) -> str:
        target = added.transitions.get(outcome)
        if target is not None and target in names:
            return names[target]
        target = target or outcome
        if target not in (found.outcomes or ()):
            raise RefusedError(f"{outcome!r} of {added.label!r} leads to {target!r}, which isn't there")
        return task_name(target)

    def _checked(self, node: AnyNode, outcomes: Mapping[str, Meaning]) -> Task:
        catalog = Catalog.builtin().with_manifests(spec.manifest for spec in self.leaves.specs.values())
        task = self._task(node, outcomes, set())
        nodes: dict[str, Any] = dict(model.walk(task.root))
        early = [issue for issue in validate(task, catalog).issues if issue.code == "read-before-write"]
        missing = {*self.variables.first, *(str(nodes[each.path].in_[str(each.key[1])]) for each in early)}
        task = self._task(userdata.mark_unwritten(node, missing), outcomes, missing)
        for issue in validate(task, catalog).issues:
            if issue.severity == "error":
                self.root.problem("partial", f"`grip check`: {issue.path}: {issue.message}")
        return task

    def _task(self, node: AnyNode, outcomes: Mapping[str, Meaning], missing: set[str]) -> Task:
        data = self.variables.declared(missing)
        local = {name for _, each in model.walk(node) for name in getattr(each, "data", {})}
        return Task(
            grip=1,
            name=self.name,
            doc=f"Imported from {self.root.span.file.name}.",
            outcomes=dict(outcomes),
            data={name: declared for name, declared in data.items() if name not in local},
            root=node,
        )
