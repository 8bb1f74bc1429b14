"""BT.CPP's nodes as its documentation says them, independently of the importer: ticked beside the imported tree.

One deviation is meant: `Repeat` and `RetryUntilSuccessful` give a tick after every attempt, as `docs/btcpp.md` says.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping

S, F, R, SKIP, IDLE = "SUCCESS", "FAILURE", "RUNNING", "SKIPPED", "IDLE"


class Reference:
    """A tree of BT.CPP, ticked by hand.

    Args:
        body: the main tree's node.
        scripts: leaf's type -> its script, as in `btcpp_world`.
    """

    def __init__(self, body: str, scripts: Mapping[str, str]):
        self.trace: list[str] = []
        self.now = 0.0
        self.nodes: list[Node] = []
        self.scripts = {name: script.split() for name, script in scripts.items()}
        self.root = Node(ET.fromstring(body), self)

    def ticks(self, times: int, period: float = 0.0) -> list[str]:
        """Return what each tick showed, with the period [s] before it: leaves ticked, `halt LEAF`, then the status."""
        said = []
        for _ in range(times):
            status = self.root.tick()
            if status != R:
                self.root.reset()
            said.append(" ".join([*self.trace, status]))
            self.trace.clear()
            self.now += period
            for node in self.nodes:
                node.ring()
        return said


class Node:
    """One node; its rule is the method with the name of its tag."""

    def __init__(self, element: ET.Element, tree: Reference):
        self.tag, self.said, self.tree = element.tag, element.attrib, tree
        self.children = [Node(child, tree) for child in element]
        self.status, self.at, self.count, self.word = IDLE, 0, 0, ""
        self.done: dict[int, str] = {}
        self.once = ""
        self.script = list(tree.scripts.get(element.tag, ["s"]))
        self.deadline: float | None = None
        self.timed_out = False
        tree.nodes.append(self)

    def tick(self) -> str:
        if self.status == IDLE and self.said.get("_failureIf") == "true":
            status = F
        elif self.status == IDLE and self.said.get("_successIf") == "true":
            status = S
        elif self.status == IDLE and self.said.get("_skipIf") == "true":
            status = SKIP
        else:
            status = getattr(self, self.tag, self.leaf)()
        if status != SKIP:
            self.status = status
        return status

    def halt(self) -> None:
        """Halt a running node; then it is idle."""
        if self.status == R:
            if not self.children:
                self.tree.trace.append(f"halt {self.tag}")
            if self.tag != "SequenceWithMemory":
                self.at = 0
            self.count, self.done, self.deadline = 0, {}, None
            for child in self.children:
                child.halt()
        self.status = IDLE

    def reset(self) -> None:
        for child in self.children:
            child.halt()
        self.status = IDLE

    def reset_children(self) -> None:
        for child in self.children:
            child.halt()

    def ring(self) -> None:
        """Do what the timer of a Timeout does when it is over: halt the child, whoever is being ticked."""
        if self.deadline is not None and self.tree.now >= self.deadline and self.children[0].status == R:
            self.timed_out = True
            self.children[0].halt()

    def Timeout(self) -> str:
        if self.deadline is None:
            self.deadline, self.timed_out = self.tree.now + int(self.said["msec"]) / 1000, False
        self.status = R
        status = F if self.timed_out else self.children[0].tick()
        if status in (S, F):
            self.deadline = None
            self.reset_children()
        return status

    def leaf(self) -> str:
        if self.status != R:
            self.word = self.script.pop(0) if len(self.script) > 1 else self.script[0]
        self.tree.trace.append(self.tag)
        if self.word.startswith("."):
            self.word = self.word[1:]
            return R
        return S if self.word == "s" else F

    def series(self, goes_on: str, ends: str, keep: bool = False) -> str:
        if self.status == IDLE:
            self.count = 0
        self.status = R
        while self.at < len(self.children):
            status = self.children[self.at].tick()
            if status == R:
                return R
            if status == ends:
                if keep:
                    self.reset_children()
                else:
                    self.reset_children()
                    self.at = 0
                return ends
            self.at += 1
            self.count += status == SKIP
        skipped = self.count == len(self.children)
        self.reset_children()
        self.at = self.count = 0
        return SKIP if skipped else goes_on

    def Sequence(self) -> str:
        return self.series(S, F)

    def Fallback(self) -> str:
        return self.series(F, S)

    def SequenceWithMemory(self) -> str:
        return self.series(S, F, keep=True)

    def reactive(self, goes_on: str, ends: str) -> str:
        skipped = True
        self.status = R
        for child in self.children:
            status = child.tick()
            skipped &= status == SKIP
            if status == R:
                for other in self.children:
                    if other is not child:
                        other.halt()
                return R
            if status == ends:
                self.reset_children()
                return ends
        self.reset_children()
        return SKIP if skipped else goes_on

    def ReactiveSequence(self) -> str:
        return self.reactive(S, F)

    def ReactiveFallback(self) -> str:
        return self.reactive(F, S)

    def Parallel(self) -> str:
        count = len(self.children)
        need = int(self.said.get("success_count", -1))
        most = int(self.said.get("failure_count", 1))
        need, most = (n if n >= 0 else count + n + 1 for n in (need, most))
        self.status = R
        for index, child in enumerate(self.children):
            if index not in self.done:
                status = child.tick()
                if status != R:
                    self.done[index] = status
            ends = list(self.done.values())
            if ends.count(S) >= need:
                return self.over(S)
            if count - ends.count(F) < need or ends.count(F) == most:
                return self.over(F)
        return R

    def ParallelAll(self) -> str:
        self.status = R
        for index, child in enumerate(self.children):
            if index not in self.done:
                status = child.tick()
                if status != R:
                    self.done[index] = status
        if len(self.done) < len(self.children):
            return R
        return self.over(F if list(self.done.values()).count(F) >= int(self.said["max_failures"]) else S)

    def over(self, status: str) -> str:
        self.done = {}
        self.reset_children()
        return status

    def IfThenElse(self) -> str:
        self.status = R
        if self.at == 0:
            status = self.children[0].tick()
            if status == R:
                return R
            if status == F and len(self.children) == 2:
                self.reset_children()
                return F
            self.at = 1 if status == S else 2
        status = self.children[self.at].tick()
        if status != R:
            self.reset_children()
            self.at = 0
        return status

    def WhileDoElse(self) -> str:
        self.status = R
        taken, other = (1, 2) if self.children[0].tick() == S else (2, 1)
        self.children[other].halt()
        status = self.children[taken].tick()
        if status != R:
            self.reset_children()
        return status

    def TryCatch(self) -> str:
        self.status = R
        last = len(self.children) - 1
        while self.at < last:
            status = self.children[self.at].tick()
            if status == R:
                return R
            if status == F:
                self.reset_children()
                self.at = last
                break
            self.at += 1
        else:
            if not self.count:
                self.reset_children()
                self.at = 0
                return S
        self.count = 1
        if self.children[last].tick() == R:
            return R
        self.reset_children()
        self.at = self.count = 0
        return F

    def decorated(self, **mapped: str) -> str:
        self.status = R
        status = self.children[0].tick()
        if status in (S, F):
            self.reset_children()
        return mapped.get(status, status)

    def Inverter(self) -> str:
        return self.decorated(SUCCESS=F, FAILURE=S)

    def ForceSuccess(self) -> str:
        return self.decorated(FAILURE=S)

    def ForceFailure(self) -> str:
        return self.decorated(SUCCESS=F)

    def again(self, goes_on: str, times: int) -> str:
        status = self.decorated()
        if status == goes_on:
            self.count += 1
            if self.count != times:
                return R
        if status != R:
            self.count = 0
        return status

    def Repeat(self) -> str:
        return self.again(S, int(self.said["num_cycles"]))

    def RetryUntilSuccessful(self) -> str:
        return self.again(F, int(self.said["num_attempts"]))

    def RunOnce(self) -> str:
        if self.once:
            return SKIP
        status = self.decorated()
        self.once = status if status in (S, F) else ""
        return status
