"""Random state machines all of whose states can be reached, with loops and early ways out, machines within machines."""

from __future__ import annotations

from random import Random
from typing import Any

from parity_generate import CODES, EXTRA, Maker


class FlowMaker(Maker):
    """Mostly makes state machines; every state but the first has an edge from an earlier one."""

    def container(
        self, kind: str, depth: int, seen: list[str], own: list[str], embedded: bool
    ) -> tuple[dict[str, Any], dict[str, str]]:
        kind = "state_machine" if self.chance(0.7) else kind
        return super().container(kind, depth, seen, own, embedded)

    def machine(
        self, children: dict[str, Any], ends: dict[str, dict[str, str]]
    ) -> tuple[dict[str, Any], dict[str, str]]:
        declared = {"success": "success", "failure": "failure", **EXTRA}
        free = [name for name in sorted(declared) if name not in children]
        outcomes = {k: declared[k] for k in self.random.sample(free, min(len(free), self.random.randint(1, 3)))}
        outcomes = outcomes or {"out": "success"}
        names = list(children)
        edges = {name: dict.fromkeys(labels, "") for name, labels in ends.items()}
        for name, labels in ends.items():
            for outcome, meaning in labels.items():
                if meaning == "failure" and self.chance(0.3):
                    edges[name][f"{outcome}.{self.random.choice(CODES)}"] = ""
        for number, name in enumerate(names[1:], 1):
            unused = [(n, label) for n in names[:number] for label, target in edges[n].items() if not target]
            before, label = self.random.choice(unused)
            edges[before][label] = name
        for number, name in enumerate(names):
            for label, target in edges[name].items():
                if not target:
                    edges[name][label] = self.target(number, names, list(outcomes))
            children[name]["on"] = edges[name]
        return {"kind": "state_machine", "initial": names[0], "outcomes": outcomes, "children": children}, outcomes

    def target(self, number: int, names: list[str], outcomes: list[str]) -> str:
        if self.chance(0.25):
            return self.random.choice(names[: number + 1])
        return self.random.choice([*outcomes, *outcomes, *names[number + 1 :]])


def make_flow(seed: int) -> dict[str, Any]:
    """Return a task whose root is such a machine, with scripts for its leaves."""
    random = Random(seed)
    maker = FlowMaker(random, embed=False, join=False)
    data = maker.variables()
    root, outcomes = maker.container("state_machine", random.randint(2, 4), list(data), list(data), False)
    task: dict[str, Any] = {"grip": 1, "name": "flowing", "root": root}
    task["outcomes"] = {"success": "success", "failure": "failure", "other": random.choice(("success", "failure"))}
    root["on"] = {outcome: random.choice(list(task["outcomes"])) for outcome in outcomes}
    if "failure" in outcomes and maker.chance(0.3):
        root["on"][f"failure.{random.choice(CODES)}"] = "other"
    if data:
        task["data"] = data
    case: dict[str, Any] = {"task": task, "scripts": maker.scripts}
    if maker.files:
        case["files"] = maker.files
    if maker.chance(0.4):
        case["preempt_at"] = random.randint(-1, 8)
    if maker.chance(0.1) and maker.scripts:
        random.choice(random.choice(list(maker.scripts.values())))[random.choice(("raises", "stops"))] = True
    return case
