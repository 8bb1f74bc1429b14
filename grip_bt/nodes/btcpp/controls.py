"""Control nodes and decorators of BehaviorTree.CPP 4.10, for children that are skipped and ports that are bound.

Each follows the rules of the node of its name, status in and status out, tick by tick.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from py_trees.common import Status

from grip_bt.nodes.btcpp.script import EPSILON, Run, text_of
from grip_bt.nodes.control import SKIPPED, Child, Control

ENDS = {"SUCCESS": "success", "FAILURE": "failure", "SKIPPED": SKIPPED, "RUNNING": "running"}


class _Counting(Control):
    def number(self, port: str) -> int:
        return int(self.get(port))

    def threshold(self, port: str) -> int:
        """Return a number of children; negative ones are counted from the end, beginning with -1."""
        said, count = self.number(port), len(self.below)
        if said > count:
            raise ValueError(f"`{port}` is {said}, and there are {count} children")
        return said if said >= 0 else max(count + said + 1, 0)


class Parallel(_Counting):
    """All children; decided after each. One that is skipped is asked again on every tick."""

    def initialise(self) -> None:
        self.done: dict[int, str] = {}

    def decide(self) -> str:
        successes, failures, skipped = self.threshold("success_count"), self.threshold("failure_count"), 0
        for _ in self.ticked():
            ends = list(self.done.values())
            well, badly, skipped = ends.count("success"), ends.count("failure"), self.skipped
            if well + (skipped if self.number("success_count") < 0 else 0) >= successes:
                return "success"
            if len(self.below) - badly < successes or badly == failures:
                return "failure"
        return SKIPPED if skipped == len(self.below) else "running"

    def ticked(self) -> Iterator[int]:
        """Tick those that haven't ended, and yield after each child."""
        self.skipped = 0
        for i, child in enumerate(self.below):
            if i not in self.done:
                end = child.tick()
                self.skipped += end == SKIPPED
                if end in ("success", "failure"):
                    self.done[i] = end
            yield i


class ParallelAll(Parallel):
    """All children to their ends."""

    def decide(self) -> str:
        failures, count = self.threshold("max_failures"), len([*self.ticked()])
        if self.skipped == count:
            return SKIPPED
        if self.skipped + len(self.done) < count:
            return "running"
        return "failure" if list(self.done.values()).count("failure") >= failures else "success"


class Series(Control):
    """The children in order, until one doesn't end `onward`; what sets its kinds apart are their settings.

    `waits`: a tick of the rest of the tree between two children. `keeps`: it goes on where it was, after a failure and
    after a halt. `reactive`: from the first child on every tick.
    """

    at = 0

    def initialise(self) -> None:
        self.skips = 0
        if not self.manifest.settings["keeps"]:
            self.at = 0

    def decide(self) -> str:
        onward, waits = str(self.manifest.settings["onward"]), self.manifest.settings["waits"]
        if self.manifest.settings["reactive"]:
            self.at = self.skips = 0
        while self.at < len(self.below):
            child = self.below[self.at]
            began = not child.running
            end = child.tick()
            if end not in (onward, SKIPPED):
                for other in self.below[self.at + 1 :]:
                    other.halt()
                return end
            self.at, self.skips = self.at + 1, self.skips + (end == SKIPPED)
            if waits and began and end == onward and self.at < len(self.below):
                self.context.wake()
                return "running"
        self.at = 0
        return SKIPPED if self.skips == len(self.below) else onward


class Repeat(_Counting):
    """`Repeat` and `RetryUntilSuccessful`: the count is kept while the child is skipped."""

    count = 0

    def decide(self) -> str:
        onward, port = self.manifest.settings["onward"], self.manifest.settings["times"]
        while self.count < self.number(port) or self.number(port) == -1:
            child = self.below[0]
            began = not child.running
            end = child.tick()
            if end in ("running", SKIPPED):
                return end
            child.halt()
            if end != onward:
                self.count = 0
                return end
            self.count += 1
            if began and (self.count < self.number(port) or self.number(port) == -1):
                self.context.wake()
                return "running"
        self.count = 0
        return str(onward)

    def halted(self) -> None:
        self.count = 0


class KeepRunningUntilFailure(Control):
    """Again after a success; a child that is skipped leaves it running."""

    def decide(self) -> str:
        end = self.below[0].tick()
        self.context.wake() if end == "success" else None
        return "failure" if end == "failure" else "running"


class Timeout(_Counting):
    """The clock goes on while the child is skipped; at the deadline it is halted before it is ticked."""

    until: float | None = None

    def decide(self) -> str:
        now, limit = self.context.clock.now(), self.number("msec")
        if self.until is None:
            self.until = now + limit / 1000
            if limit > 0:
                self.context.wake_at(self.until)
        child = self.below[0]
        if limit > 0 and now >= self.until and child.running:
            child.halt()
            self.until = None
            return "failure"
        end = child.tick()
        if end in ("success", "failure"):
            self.until = None
        return end

    def halted(self) -> None:
        self.until = None


class Delay(_Counting):
    """The child, after a delay."""

    def initialise(self) -> None:
        self.at = self.context.clock.now() + self.number("delay_msec") / 1000
        self.context.wake_at(self.at)

    def decide(self) -> str:
        return self.below[0].tick() if self.context.clock.now() >= self.at else "running"


class Loop(Control):
    """The child for each item of a queue, which is taken from the front of the list that the entry holds."""

    def initialise(self) -> None:
        self.queue: list[Any] | None = None

    def decide(self) -> str:
        child = self.below[0]
        if not child.running:
            held = self.get("queue")
            if isinstance(held, str):
                convert = {"int": int, "float": float, "bool": lambda t: t in ("true", "1"), "str": str}
                make: Any = convert[self.manifest.settings["item"]]
                self.queue = [make(part) for part in held.split(";") if held] if self.queue is None else self.queue
            else:
                self.queue = list(held or ())
            if not self.queue:
                return ENDS[str(self.get("if_empty"))]
            self.put("value", self.queue.pop(0))
            if not isinstance(held, str):
                self.put("queue", list(self.queue))
        if child.tick() == "failure":
            return "failure"
        if not child.running:
            self.context.wake()
        return "running"


class Updated(Control):
    """`SkipUnlessUpdated`, `WaitValueUpdate`: the child when the entry was written since it was last asked."""

    watched = ("entry",)
    seen = 0

    def decide(self) -> str:
        child = self.below[0]
        if not child.running:
            if self.writes["entry"] == self.seen:
                return str(self.manifest.settings["else"])
            self.seen = self.writes["entry"]
        return child.tick()


class WasUpdated(Control):
    """`WasEntryUpdated`: whether the entry was written since it was last asked."""

    watched = ("entry",)
    seen = 0

    def decide(self) -> str:
        before, self.seen = self.seen, self.writes["entry"]
        return "failure" if before == self.seen else "success"


class Switch(Control):
    """The child whose case is the variable's text, number or enum's word, looked at on every tick; else the last."""

    def decide(self) -> str:
        value, chosen = self.get("variable"), len(self.below) - 1
        for i in range(chosen):
            if value is not None and same_text(value, self.get(f"case_{i + 1}")):
                chosen = i
                break
        for i, child in enumerate(self.below):
            if i != chosen and child.running:
                child.halt()
        return self.below[chosen].tick()


def same_text(value: object, case: object) -> bool:
    """Tell whether two texts are the same, or numbers that are."""
    one, other = text_of(value), text_of(case)
    if one == other:
        return True
    try:
        return abs(float(one) - float(other)) <= EPSILON
    except ValueError:
        return False


class IfThenElse(Control):
    """The second or the third child, by the end of the first."""

    def initialise(self) -> None:
        self.at = 0

    def decide(self) -> str:
        if self.at == 0:
            end = self.below[0].tick()
            if end == SKIPPED:
                raise ValueError("its condition was skipped, which is an error in BehaviorTree.CPP")
            if end == "running" or (end == "failure" and len(self.below) < 3):
                return end
            self.at = 1 if end == "success" else 2
        return self.below[self.at].tick()


class WhileDoElse(Control):
    """The second or the third child, by the end of the first, which is asked on every tick."""

    def decide(self) -> str:
        end = self.below[0].tick()
        if end not in ("success", "failure"):
            return end
        chosen = self.below[1:2] if end == "success" else self.below[2:]
        for child in self.below[1:]:
            if child not in chosen:
                child.halt()
        return chosen[0].tick() if chosen else "failure"


class TryCatch(Control):
    """The children in order; when one has failed, or where that is asked for when it is halted, the last one."""

    def initialise(self) -> None:
        self.at, self.skips = 0, 0

    def decide(self) -> str:
        *tried, caught = self.below
        while self.at < len(tried):
            end = tried[self.at].tick()
            if end == "running":
                return end
            if end == "failure":
                self.at = len(self.below)
                self._reset(tried)
                break
            self.at, self.skips = self.at + 1, self.skips + (end == SKIPPED)
        else:
            if self.at == len(tried):
                return SKIPPED if self.skips == len(tried) else "success"
        return "running" if caught.tick() == "running" else "failure"

    def halted(self) -> None:
        *tried, caught = self.below
        if self.get("catch_on_halt") in (True, "true", "1", 1) and self.at < len(self.below):
            self._reset(tried)
            caught.tick()

    def _reset(self, children: list[Child]) -> None:
        for child in children:
            child.halt()


class OnHalted(Control):
    """The child; a script is run when it was halted, over the entries `a` to `h`."""

    def decide(self) -> str:
        return self.below[0].tick()

    def halted(self) -> None:
        self.below[0].halt()
        Run(self.get, self.put).script(self.params["code"])


class Script(Control):
    """A script that no expression is equal to, over the entries `a` to `h`; `value` is whether its last value holds."""

    def update(self) -> Status:
        value = Run(self.get, self.put).script(self.params["code"])
        return self.end(value=bool(value))


class AlwaysRunning(Control):
    """Goes on until it is halted."""

    def decide(self) -> str:
        return "running"
