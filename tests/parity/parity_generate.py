"""Random tasks over every kind of node, with scripts for their leaves."""

from __future__ import annotations

from dataclasses import dataclass, field
from random import Random
from typing import Any

from oracle.running import FACES

CODES = ("no_ik", "no_plan", "time_out")
EDGE_CODES = (*CODES, *CODES, "precondition", "guard", "no_case", "cooldown", "loop_limit")
EXTRA = {"won": "success", "lost": "failure", "none": "success"}
SEQUENTIAL = ("sequence", "fallback", "state_machine", "retry", "repeat", "invert", "force", "subtask")
CHOOSING = ("switch", "loop", "for_each", "cooldown", "round_robin")
BRANCHING = ("sequence", "fallback", "state_machine")
INTERRUPTING = ("reactive_sequence", "reactive_fallback", "reactive_switch", "timeout", "guard", "parallel", "parallel")


class Seen(str):
    """A variable's name, and whether it has a value from the beginning."""

    valued = False


def seen_of(data: dict[str, Any]) -> list[Seen]:
    """Return the names that a container declares."""
    names = [Seen(name) for name in data]
    for name in names:
        name.valued = isinstance(data[name], dict)
    return names


@dataclass
class Maker:
    random: Random
    embed: bool
    join: bool
    scripts: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    leaves: int = 0
    names: int = 0
    concurrent: bool = False
    files: dict[str, dict[str, Any]] = field(default_factory=dict)
    """The files that subtasks run."""
    without: tuple[str, ...] = ()
    """Kinds and settings that aren't made."""
    shared: bool = False
    """Whether the children of a concurrence share variables, in their order."""
    ends_of: dict[str, dict[str, str]] = field(default_factory=dict)
    """File -> its outcomes."""

    def chance(self, probability: float) -> bool:
        return self.random.random() < probability

    def name(self) -> str:
        if self.chance(0.05):
            return self.random.choice(("success", "failure", "won", "task"))
        self.names += 1
        return f"n{self.names}"

    def node(
        self, depth: int, seen: list[str], own: list[str], embedded: bool, usual: str
    ) -> tuple[dict[str, Any], dict[str, str]]:
        """Return a node and its outcomes; it may read the variables `seen` and write those in `own`.

        A leaf mostly ends with the `usual` meaning, so that what comes after it is reached.
        """
        node, outcomes = self.bare(depth, seen, own, embedded, usual)
        if outcomes.get("failure") != "success" and self.chance(0.08) and "precondition" not in self.without:
            node["precondition"] = self.condition(seen)
            outcomes = {**outcomes, "failure": "failure"}
        return node, outcomes

    def condition(self, seen: list[str]) -> str:
        """Return an expression; now and then one over a variable that may not be written, which ends the run."""
        there = list({str(name): name for name in seen}.values())  # an inner one hides an outer one
        there = [str(name) for name in there if getattr(name, "valued", False) or self.chance(0.05)]
        if not there:
            return "true" if self.chance(0.8) else "1 > 2"
        one, other, limit = self.random.choice(there), self.random.choice(there), self.random.randint(0, 30)
        return self.random.choice(
            (
                f"{one} % 5 != {limit % 5}",
                f"{one} >= {limit}",
                f"{one} + {other} > {limit} or {one} == {limit % 10}",
                f"not {one} in [{limit}, {other} - 1] and abs({one} - {limit}) > 2",
                f"max({one}, {limit}) < 60",
            )
        )

    def bare(
        self, depth: int, seen: list[str], own: list[str], embedded: bool, usual: str
    ) -> tuple[dict[str, Any], dict[str, str]]:
        if depth <= 0 or self.leaves > 24 or self.chance((0.4, 0.25, 0.1, 0.02)[min(depth, 4) - 1]):
            return self.leaf(seen, own, usual)
        kinds = [*SEQUENTIAL, *SEQUENTIAL, *BRANCHING, *BRANCHING, *CHOOSING]
        if self.embed:
            kinds += 2 * INTERRUPTING
        if self.join:
            kinds += ("join",) * 6
            kinds = [kind for kind in kinds if kind not in ("cooldown", "timeout")]  # threads share the clock
        kinds = [kind for kind in kinds if kind not in self.without]
        return self.container(self.random.choice(kinds), depth, seen, own, embedded)

    def leaf(self, seen: list[str], own: list[str], usual: str) -> tuple[dict[str, Any], dict[str, str]]:
        if self.chance(0.04):
            made = {"kind": "foreign", "behaviour": "py_trees.behaviours:SuccessEveryN", "args": {"n": 2}}
            made |= {"behaviour": "py_trees.behaviours:Success", "args": {}} if self.chance(0.3) else {}
            return made, {"success": "success", "failure": "failure"}
        self.leaves += 1
        script = f"s{self.leaves}"
        face = self.random.choice(list(FACES))
        node: dict[str, Any] = {"node": face, "with": {"script": script}}
        for key, ports, variables in (("in", "ab", seen), ("out", "xy", own)):
            bound = {port: str(self.random.choice(variables)) for port in ports if variables and self.chance(0.5)}
            if bound:
                node[key] = bound
        outcomes = dict(FACES[face])
        if self.chance(0.1):
            changed = self.random.choice(list(outcomes))
            node["meaning"] = {changed: self.random.choice(("success", "failure"))}
            outcomes.update(node["meaning"])
        self.scripts[script] = [self.step(face, usual) for _ in range(self.random.randint(1, 4))]
        return node, outcomes

    def step(self, face: str, usual: str) -> dict[str, Any]:
        step: dict[str, Any] = {"outcome": usual if self.chance(0.75) else self.random.choice(list(FACES[face]))}
        if self.chance(0.4):
            step["ticks"] = self.random.randint(1, 3)
        if self.chance(0.5):
            step["code"] = self.random.choice(CODES)
        if self.chance(0.4):
            step["advance"] = self.random.randint(1, 3)
        return step

    def container(
        self, kind: str, depth: int, seen: list[str], own: list[str], embedded: bool
    ) -> tuple[dict[str, Any], dict[str, str]]:
        if kind == "subtask":
            return self.subtask(depth, seen, own, embedded)
        data = self.variables()
        seen, own = [*seen, *seen_of(data)], [*own, *data]
        there, item = seen, self.random.choice([name for name in "uvw" if name not in data])
        if kind == "for_each":
            seen, own = [*seen, *seen_of({item: {}})], [*own, item]
        if kind == "join" and not embedded:
            self.concurrent = True
        inside = embedded or kind in INTERRUPTING
        usual = "failure" if kind in ("fallback", "reactive_fallback", "retry") else "success"
        single = kind in ("retry", "repeat", "invert", "force", "timeout", "guard", "loop", "for_each", "cooldown")
        children: dict[str, Any] = {}
        ends: dict[str, dict[str, str]] = {}
        for _ in range(1 if single else self.random.choice((2, 2, 3, 3, 4))):
            name = self.name()
            # Without a turnstile the children of a concurrence write only what they declare, or their order would show.
            writable = [] if kind == "join" and not embedded and not self.shared else own
            children[name], ends[name] = self.node(depth - 1, seen, writable, inside, usual)
        if kind == "state_machine":
            node, outcomes = self.machine(children, ends)
        else:
            node = self.plain(kind, children, there)
            outcomes = {"success": "success", "failure": "failure"}
            if self.chance(0.35):
                node["outcomes"] = {k: EXTRA[k] for k in self.random.sample(sorted(EXTRA), self.random.randint(1, 2))}
                outcomes.update(node["outcomes"])
                node["exits"] = self.exits(ends, list(outcomes))
            if kind in ("parallel", "join"):
                node.update(self.rules(ends, list(outcomes), kind == "join"))
                if self.shared:
                    node["order"] = "declared"
        if kind == "for_each":
            items = [self.random.randint(0, 9) for _ in range(self.random.choice((0, 1, 2, 3, 3)))]
            node["item"], data = item, {**data, "list": {"type": "list[int]", "value": items}}
        if data:
            node["data"] = data
        return node, outcomes

    def rules(self, ends: dict[str, dict[str, str]], targets: list[str], join: bool) -> dict[str, Any]:
        """Return how a parallel is decided, beyond policy and exits."""
        made: dict[str, Any] = {}
        if self.chance(0.5):
            made["rules"] = [self.rule(ends, targets) for _ in range(self.random.randint(1, 3))]
        if join:
            return made
        if self.chance(0.5):
            some = self.random.sample(list(ends), self.random.randint(1, len(ends)))
            made["wait_for"] = self.random.choice(("all", "any", self.random.randint(1, len(ends) + 1), some))
        if self.chance(0.4):
            made["cancel"] = "ask"
        elif self.chance(0.5) and "retick" not in self.without:
            made[self.random.choice(("retick", "prompt"))] = True
        return made

    def subtask(
        self, depth: int, seen: list[str], own: list[str], embedded: bool
    ) -> tuple[dict[str, Any], dict[str, str]]:
        """Return a node that runs a file: mostly a new one, now and then one that is there already."""
        if not self.files or self.chance(0.8):
            self.file(depth)
        file = self.random.choice(list(self.files))  # one that is there runs no file that runs it
        made = self.files[file]
        node: dict[str, Any] = {"kind": "subtask", "task": file}
        there = [str(name) for name in {str(n): n for n in seen}.values() if getattr(name, "valued", False)]
        for port, said in made.get("inputs", {}).items():
            if there and self.chance(0.6):
                node.setdefault("in", {})[port] = self.random.choice(there)
            elif isinstance(said, str) or self.chance(0.5):
                node.setdefault("with", {})[port] = self.random.randint(0, 9)
        for port in made.get("outputs", {}):
            if own and self.chance(0.7):
                node.setdefault("out", {})[port] = str(self.random.choice(own))
        outcomes = dict(self.ends_of[file])
        if self.chance(0.15):
            changed = self.random.choice(list(outcomes))
            node["meaning"] = {changed: self.random.choice(("success", "failure"))}
            outcomes |= node["meaning"]
        return node, outcomes

    def file(self, depth: int) -> None:
        """Write a file with ports of its own; it may be run anywhere."""
        ports = {
            name: self.random.choice(("int", {"type": "int", "value": 4})) for name in ("u", "v") if self.chance(0.5)
        }
        handed = {name: "int" for name in ("v", "w") if self.chance(0.5)}
        data = {k: v for k, v in self.variables().items() if k not in ports and k not in handed}
        seen = seen_of({**data, **handed, **ports})
        for name in seen:
            name.valued = name.valued or name in ports
        root, ends = self.node(depth - 1, seen, [*data, *handed, *ports], False, "success")
        outcomes = {k: EXTRA[k] for k in self.random.sample(sorted(EXTRA), self.random.randint(0, 2))}
        outcomes |= {"success": "success", "failure": "failure"}
        root["on"] = {end: self.random.choice(list(outcomes)) for end in ends if self.chance(0.6)}
        for end in ends:
            if end in root["on"] and self.chance(0.3):
                root["on"][f"{end}.{self.random.choice(EDGE_CODES)}"] = self.random.choice(list(outcomes))
        task = {"grip": 1, "name": self.name(), "outcomes": outcomes, "inputs": ports, "outputs": handed, "data": data}
        name = f"tasks/f{len(self.files)}.yaml"
        self.files[name] = {k: v for k, v in task.items() if v} | {"root": root}
        self.ends_of[name] = outcomes

    def rule(self, ends: dict[str, dict[str, str]], targets: list[str]) -> dict[str, Any]:
        rule: dict[str, Any] = {"then": self.random.choice(targets)}
        if self.chance(0.7):
            for child in self.random.sample(list(ends), self.random.randint(1, min(2, len(ends)))):
                labels = self.random.sample(list(ends[child]), self.random.randint(1, len(ends[child])))
                rule.setdefault("when", {})[child] = labels if len(labels) > 1 else labels[0]
        if self.chance(0.4):
            rule |= {"at_least": self.random.randint(1, 3), "ends": self.random.choice(("success", "failure"))}
        return rule

    def cases(self, children: dict[str, Any], seen: list[str]) -> dict[str, Any]:
        """Return what a switch compares; now and then it has no case for a value, or no child for a case."""
        there = [str(name) for name in {str(n): n for n in seen}.values() if getattr(name, "valued", False)]
        value = f"{self.random.choice(there)} % 4" if there else str(self.random.randint(0, 3))
        literals = self.random.sample(range(4), 4)
        cases: dict[str, Any] = {}
        for name in children:
            taken = [literals.pop() for _ in range(self.random.choice((1, 1, 2))) if literals]
            if taken:
                cases[name] = taken if len(taken) > 1 else taken[0]
        default = {"default": self.random.choice(list(children))} if self.chance(0.4) else {}
        return {"on_value": value, "cases": cases, **default}

    def variables(self) -> dict[str, Any]:
        if not self.chance(0.35):
            return {}
        made = self.random.sample(("u", "v", "w"), self.random.randint(1, 2))
        return {
            name: {"type": "int", "value": self.random.randint(0, 9)} if self.chance(0.6) else "int" for name in made
        }

    def plain(self, kind: str, children: dict[str, Any], seen: list[str]) -> dict[str, Any]:
        times = self.random.randint(1, 3)
        child = next(iter(children.items()))
        only = {"child": {child[0]: child[1]}}
        endless = any("script" in str(below) for below in child[1:])  # who does nothing would do so for ever
        late = {"child_first": True} if self.chance(0.3) else {}
        limit = {} if endless and self.chance(0.2) else {"times": times}
        made: dict[str, dict[str, Any]] = {
            "switch": {"kind": "switch", **self.cases(children, seen), "children": children},
            "loop": {"kind": "loop", **({"while": self.condition(seen)} if self.chance(0.6) else {}), **limit, **only},
            "for_each": {"kind": "for_each", "items": "list", **only},
            "cooldown": {"kind": "cooldown", "seconds": self.random.randint(1, 6), **only},
            "round_robin": {"kind": "round_robin", "children": children},
            "sequence": {"kind": "sequence", "children": children},
            "fallback": {"kind": "fallback", "children": children},
            "reactive_sequence": {"kind": "sequence", "memory": False, "children": children},
            "reactive_fallback": {"kind": "fallback", "memory": False, "children": children},
            "reactive_switch": {"kind": "switch", "memory": False, **self.cases(children, seen), "children": children},
            "parallel": {"kind": "parallel", "policy": self.random.choice(("all", "any")), "children": children},
            "join": {
                "kind": "parallel",
                "policy": self.random.choice(("all", "any")),
                "cancel": "join",
                "children": children,
            },
            "retry": {"kind": "retry", "times": times, **only},
            "repeat": {"kind": "repeat", **limit, **only},
            "timeout": {"kind": "timeout", "seconds": self.random.randint(1, 6), **late, **only},
            "guard": {"kind": "guard", "if": self.condition(seen), **only},
            "invert": {"kind": "invert", **only},
            "force": {"kind": "force", "as": self.random.choice(("success", "failure")), **only},
        }
        return made[kind]

    def exits(self, ends: dict[str, dict[str, str]], targets: list[str]) -> dict[str, str]:
        exits = {}
        for child, outcomes in ends.items():
            for outcome in outcomes:
                if self.chance(0.1):
                    exits[f"{child}.{outcome}"] = self.random.choice(targets)
                if self.chance(0.25):
                    exits[f"{child}.{outcome}.{self.random.choice(EDGE_CODES)}"] = self.random.choice(targets)
        return exits

    def machine(
        self, children: dict[str, Any], ends: dict[str, dict[str, str]]
    ) -> tuple[dict[str, Any], dict[str, str]]:
        declared = {"success": "success", "failure": "failure", **EXTRA}
        outcomes = {k: declared[k] for k in self.random.sample(sorted(declared), self.random.randint(1, 3))}
        targets = [*outcomes, *outcomes, *children, *children, *children]
        for child, labels in ends.items():
            on = {outcome: self.random.choice(targets) for outcome in labels}
            for outcome in labels:
                if self.chance(0.3):
                    on[f"{outcome}.{self.random.choice(EDGE_CODES)}"] = self.random.choice(targets)
            children[child]["on"] = on
        initial = self.random.choice(list(children))
        return {"kind": "state_machine", "initial": initial, "outcomes": outcomes, "children": children}, outcomes


def make_turns(seed: int) -> dict[str, Any]:
    """Return a random task with concurrent parts whose leaves share variables, for runs in the order of a turnstile.

    Only leaves pass a turnstile, so that nothing else in it looks at variables, and nothing stops it from outside.
    """
    case = make_case(seed, (*CHOOSING, "subtask", "guard", "reactive_switch", "precondition"), shared=True)
    case.pop("preempt_at", None)
    for step in (step for steps in case["scripts"].values() for step in steps):
        step.pop("raises", None)
        step.pop("stops", None)
    return case


def make_case(
    seed: int, without: tuple[str, ...] = (), shared: bool = False, random: Random | None = None
) -> dict[str, Any]:
    """Return a random task with scripts; three in five have no part that must be embedded.

    One in five has concurrent parts: its leaves' own sequences are compared, so that nothing in it depends on the order
    of siblings but when a request, a stop or an error reaches them (no timeout, whose clock they share).

    Args:
        seed: of everything.
        without: kinds and settings that it hasn't.
        shared: whether it has concurrent parts in which variables are shared.
        random: draws in place of those of the seed, of which only the flavour remains.
    """
    random = random or Random(seed)
    flavour = seed % 5
    maker = Maker(random, embed=flavour in (3, 4) or seed % 15 == 2, join=shared or flavour == 2, without=without)
    maker.shared = shared
    data = maker.variables()
    root, outcomes = maker.node(random.randint(2, 5), seen_of(data), list(data), False, "success")
    task: dict[str, Any] = {"grip": 1, "name": "fuzzed", "root": root}
    task["outcomes"] = {"success": "success", "failure": "failure", "other": random.choice(("success", "failure"))}
    root["on"] = {outcome: random.choice(list(task["outcomes"])) for outcome in outcomes}
    for outcome in outcomes:
        if maker.chance(0.2):
            root["on"][f"{outcome}.{random.choice(EDGE_CODES)}"] = random.choice(list(task["outcomes"]))
    if data:
        task["data"] = data
    case: dict[str, Any] = {"task": task, "scripts": maker.scripts}
    if maker.files:
        case["files"] = maker.files
    if maker.concurrent:
        case["concurrent"] = True
    if maker.chance(0.4):
        case["preempt_at"] = random.randint(-1, 8)
    if maker.embed:
        case["embedded"] = True
    if maker.chance(0.15) and maker.scripts:
        steps = random.choice(list(maker.scripts.values()))
        random.choice(steps)[random.choice(("raises", "stops"))] = True
    return case


def outside_of(seed: int) -> dict[str, float]:
    """Return what comes to a run from outside between two ticks: time, and in some runs a request or a stop."""
    random = Random(f"outside {seed}")
    chosen: dict[str, float] = {"period": random.choice((0.25, 1, 1, 2))} if random.random() < 0.7 else {}
    for what in ("preempt_tick", "stop_tick"):
        if random.random() < 0.15:
            chosen[what] = random.randint(1, 12)
    return chosen
