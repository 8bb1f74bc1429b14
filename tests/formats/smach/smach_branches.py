"""Random machines whose Concurrences hold containers, in the words of `smach_lowerings.Draw`.

Siblings take turns, branch by branch. A branch ends with a state of its own, so that the next one knows when it may go.
"""

from smach_lowerings import Draw
from smach_sources import LAST


class Branches(Draw):
    """Machines with Concurrences of state machines, iterators and states."""

    def machine(self):
        """Return a spec of a root that holds such a Concurrence."""
        spec = super().machine()
        while f"'{LAST}'" not in str(spec):
            spec = super().machine()
        return spec

    def container(self, depth):
        return self.concurrence() if self.random.random() < 0.5 else super().container(depth)

    def concurrence(self):
        spec = super().concurrence()
        whole = self.random.sample(range(len(spec["children"])), self.random.randint(1, len(spec["children"])))
        for number in whole:
            label, leaf, remapping = spec["children"][number]
            spec["children"][number] = [label, Inside(self.random, leaf["in"][0]).branch(leaf), remapping]
        spec["map"] = {"succeeded": {label: child["outcomes"][0] for label, child, _ in spec["children"]}}
        return spec


class Inside(Draw):
    """What is in one branch: it has one key, so that the order of siblings' writes doesn't show."""

    def __init__(self, random, key):
        self.random, self.KEYS = random, (key,)

    def branch(self, last):
        """Return a state machine that ends with a leaf."""
        body = self.container(1)
        to_last = [["BODY", body, dict.fromkeys(body["outcomes"], LAST), {}]]
        states = [*to_last, [LAST, last, {outcome: outcome for outcome in last["outcomes"]}, {}]]
        keys = list(self.KEYS)
        return {"kind": "sm", "outcomes": last["outcomes"], "initial": None, "states": states, "in": keys, "out": keys}

    def container(self, depth):
        return self.iterator(depth) if self.random.random() < 0.5 else self.state_machine(depth)

    def iterator(self, depth):
        """Return an Iterator that doesn't stumble, and begins with a state: where it waits is known."""
        spec = super().iterator(depth)
        ends = {outcome: self.random.choice(spec["outcomes"]) for outcome in spec["child"]["outcomes"]}
        return spec | {"items": spec["items"] or [0], "final": ends | spec["final"]}
