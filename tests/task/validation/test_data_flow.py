"""The data-flow analysis against a small interpreter of tasks that lets every leaf end as it likes."""

from contextlib import suppress
from random import Random

from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from grip_bt.task import (
    Cooldown,
    Fallback,
    Force,
    ForEach,
    Guard,
    Invert,
    Leaf,
    Loop,
    Parallel,
    Repeat,
    Retry,
    Sequence,
    StateMachine,
    Switch,
    Task,
    Timeout,
    children_of,
)
from grip_bt.task.catalog import Catalog, InputPort, Manifest, OutputPort
from grip_bt.task.model import join
from grip_bt.task.validation import validate

NODE = Manifest(
    id="demo/leaf",
    doc="Reads and writes.",
    implementation="demo:Leaf",
    inputs={"a": InputPort(type="int", required=False)},
    outputs={
        "x": OutputPort(type="int"),
        "y": OutputPort(type="int", on=("failure", "other")),
    },
    outcomes={"success": "success", "other": "success", "failure": "failure"},
)
CATALOG = Catalog([NODE])
WRITTEN = {"success": ("x",), "other": ("x", "y"), "failure": ("y",)}
variables = st.sampled_from(["u", "v"])
names = ["c0", "c1", "c2", "c3"]
KINDS = (
    *("sequence", "fallback", "parallel", "state_machine", "switch"),
    *("for_each", "loop", "cooldown", "once", "retry", "repeat", "timeout", "guard", "invert", "force"),
)


@st.composite
def leaves(draw):
    return {
        "node": "demo/leaf",
        "in": {"a": draw(variables)} if draw(st.integers(0, 3)) else {},
        "out": draw(st.dictionaries(st.sampled_from(["x", "y"]), variables, max_size=2)),
    }


@st.composite
def containers(draw, nodes):
    kind = draw(st.sampled_from(KINDS if draw(st.booleans()) else KINDS[:5]))
    data = draw(st.dictionaries(variables, st.sampled_from(["int", {"type": "int", "value": 1}]), max_size=1))
    count = draw(st.integers(2, 4)) if kind in KINDS[:5] else 1
    children = {name: draw(nodes) for name in names[:count]}
    if kind == "state_machine":
        outcomes = {"success": "success", "failure": "failure"}
        targets = st.sampled_from([*children, *outcomes])
        for name, child in children.items():
            ends = ("success", "other", "failure") if "node" in child else ("success", "failure")
            children[name] = {**child, "on": {end: draw(targets) for end in ends}}
        return {"kind": kind, "initial": "c0", "outcomes": outcomes, "children": children, "data": data}
    exits = {}
    for name, child in children.items():
        if draw(st.integers(0, 3)) == 0:
            end = draw(st.sampled_from(["success", "failure"] + ["other"] * ("node" in child)))
            exits[f"{name}.{end}"] = draw(st.sampled_from(["success", "failure"]))
    node = {"kind": kind, "data": data, "exits": exits}
    if count > 1 or kind in KINDS[:5]:
        node["children"] = children
    else:
        node["child"] = children
    extra = {
        "retry": {"times": 2},
        "repeat": {"times": 2},
        "timeout": {"seconds": 1.0},
        "switch": {
            "on_value": f"{draw(variables)} + 0",
            "cases": {name: i for i, name in enumerate(children)},
            **({"default": "c0"} if draw(st.booleans()) else {}),
        },
        "for_each": {"items": "list", "item": "w"},
        "loop": {"while": f"{draw(variables)} > 0"} if draw(st.booleans()) else {},
        "cooldown": {"seconds": 1.0},
        "guard": {"if": f"{draw(variables)} > 0"},
        "force": {"as": draw(st.sampled_from(["success", "failure"]))},
        "parallel": {
            "policy": draw(st.sampled_from(["all", "any"])),
            "cancel": draw(st.sampled_from(["halt", "join"])),
        },
    }
    if draw(st.integers(0, 5)) == 0:
        node["precondition"] = f"{draw(variables)} > 0"
    return {**node, **extra.get(kind, {})}


roots = containers(st.recursive(leaves(), containers, max_leaves=8))


class Run:
    """One run: leaves end as `random` likes; a read of an unwritten variable is noted."""

    def __init__(self, task, random):
        self.random, self.unwritten, self.steps = random, set(), 0
        with suppress(RecursionError):  # what was read up to then counts
            self.node(task.root, "/", [self.fresh(task.data)])

    def fresh(self, data):
        return {name: not isinstance(v, str) and v.has_value for name, v in data.items()}

    def scope(self, scopes, name):
        return next(scope for scope in reversed(scopes) if name in scope)

    def node(self, node, path, scopes):
        self.steps += 1
        if self.steps > 30:
            raise RecursionError
        if isinstance(node, Leaf):
            return self.leaf(node, path, scopes)
        if node.precondition and not self.holds(node.precondition, path, scopes):
            return "failure"
        scopes = [*scopes, self.fresh(node.data)]
        go = {
            Sequence: lambda: self.in_order(node, path, scopes, "success"),
            Fallback: lambda: self.in_order(node, path, scopes, "failure"),
            Parallel: lambda: self.parallel(node, path, scopes),
            StateMachine: lambda: self.machine(node, path, scopes),
            Switch: lambda: self.switch(node, path, scopes),
            ForEach: lambda: self.passes(node, path, [*scopes, {node.item: True}]),
            Loop: lambda: self.passes(node, path, scopes),
        }
        return go.get(type(node), lambda: self.decorated(node, path, scopes))()

    def holds(self, expression, path, scopes):
        """Read the variable that an expression begins with; what comes out is anybody's guess."""
        if not self.scope(scopes, expression[0])[expression[0]]:
            self.unwritten.add((path, expression))
        return self.random.random() < 0.8

    def leaf(self, node, path, scopes):
        for port, name in node.in_.items():
            if not self.scope(scopes, name)[name]:
                self.unwritten.add((path, port))
        end = self.random.choice(list(WRITTEN))
        for port in WRITTEN[end]:
            if port in node.out:
                self.scope(scopes, node.out[port])[node.out[port]] = True
        return end

    def ended(self, node, name, label):
        """Return (exit, None) or (None, meaning)."""
        exit_ = node.exits.get(f"{name}.{label}")
        return exit_, "failure" if label == "failure" else "success"

    def in_order(self, node, path, scopes, goes_on):
        for name, child in node.children.items():
            exit_, meaning = self.ended(node, name, self.node(child, join(path, name), scopes))
            if exit_ or meaning != goes_on:
                return exit_ or meaning
        return goes_on

    def parallel(self, node, path, scopes):
        """Children one after the other in any order, blind to each other's writes; some may be cut off."""
        one, every = ("failure", "success") if node.policy == "all" else ("success", "failure")
        before = [dict(scope) for scope in scopes]
        results, decided = [], None
        for name, child in self.random.sample(list(node.children.items()), len(node.children)):
            mine = [dict(scope) for scope in before]
            exit_, meaning = self.ended(node, name, self.node(child, join(path, name), mine))
            if exit_:
                decided = decided or exit_
            elif meaning == one:
                decided = decided or one
            if decided is None or node.cancel == "join" or not results or exit_ or meaning == one:
                results.append(mine)
            if decided and node.cancel == "halt":
                break
        for mine in results:
            for scope, seen in zip(scopes, mine, strict=True):
                for name, written in seen.items():
                    scope[name] = scope[name] or written
        return decided or every

    def machine(self, node, path, scopes):
        name = node.initial
        while name in node.children:
            child = node.children[name]
            name = child.on[self.node(child, join(path, name), scopes)]
        return name

    def switch(self, node, path, scopes):
        self.holds(node.on_value, path, scopes)
        name = self.random.choice([*node.children, node.default])
        if not name:
            return "failure"
        exit_, meaning = self.ended(node, name, self.node(node.children[name], join(path, name), scopes))
        return exit_ or meaning

    def passes(self, node, path, scopes):
        ((name, child),) = node.child.items()
        if isinstance(node, ForEach) and not self.scope(scopes, node.items)[node.items]:
            self.unwritten.add((path, node.items))
        for _ in range(3):
            if isinstance(node, Loop) and node.while_ and not self.holds(node.while_, path, scopes):
                return "success"
            if isinstance(node, ForEach) and self.random.random() < 0.3:
                return "success"
            exit_, meaning = self.ended(node, name, self.node(child, join(path, name), scopes))
            if exit_ or meaning == "failure":
                return exit_ or meaning
        if isinstance(node, Loop):
            raise RecursionError
        return "success"

    def decorated(self, node, path, scopes):
        ((name, child),) = children_of(node).items()
        for attempt in range(getattr(node, "times", 1)):
            if isinstance(node, Timeout) and self.random.random() < 0.2:
                return "failure"
            if isinstance(node, Cooldown) and self.random.random() < 0.2:
                return "failure"
            if isinstance(node, Guard) and not self.holds(node.if_, path, scopes):
                return "failure"
            exit_, meaning = self.ended(node, name, self.node(child, join(path, name), scopes))
            if exit_:
                return exit_
            again = {Retry: "failure", Repeat: "success"}.get(type(node))
            if meaning != again or attempt + 1 == node.times:
                break
        if isinstance(node, Invert):
            return "failure" if meaning == "success" else "success"
        return node.as_ if isinstance(node, Force) else meaning


def found_in(task):
    report = validate(task, CATALOG)
    return {i.path for i in report.issues if i.code == "read-before-write"}


def task_of(root):
    data = {"u": "int", "v": "int", "list": {"type": "list[int]", "value": []}}
    return Task.model_validate({"grip": 1, "name": "t", "data": data, "root": root})


class Script:
    """Choices in a fixed order, and the script of the run after this one: a walk through all runs."""

    def __init__(self, digits):
        self.digits, self.taken = list(digits), []

    def choice(self, options):
        at = len(self.taken)
        digit = self.digits[at] if at < len(self.digits) else 0
        self.taken.append((digit, len(options)))
        return options[digit]

    def random(self):
        return self.choice([0.9, 0.1])

    def following(self):
        taken = list(self.taken)
        while taken and taken[-1][0] + 1 == taken[-1][1]:
            taken.pop()
        return [digit for digit, _ in taken[:-1]] + [taken[-1][0] + 1] if taken else None


def reads_in_all_runs(task, limit):
    """Return the paths of reads that are unwritten in some run; None when there are more than `limit` runs."""
    seen, digits = set(), []
    for _ in range(limit):
        script = Script(digits)
        seen |= {path for path, _ in Run(task, script).unwritten}
        digits = script.following()
        if digits is None:
            return seen
    return None


@settings(deadline=None, max_examples=150, suppress_health_check=list(HealthCheck))
@given(roots, st.integers(0, 2**32))
def test_no_run_reads_an_unwritten_variable_that_the_analysis_hasnt_found(root, seed):
    task, random = task_of(root), Random(seed)
    found = found_in(task)
    for _ in range(25):
        assert {path for path, _ in Run(task, random).unwritten} <= found


@settings(deadline=None, max_examples=50, suppress_health_check=list(HealthCheck))
@given(roots)
def test_without_parallels_the_analysis_finds_exactly_what_happens_in_some_run(root):
    assume("parallel" not in str(root))
    task = task_of(root)
    seen = reads_in_all_runs(task, 500)
    assume(seen is not None)
    assert found_in(task) == seen
