"""Nav2's control nodes and decorators that look at nothing but their children, ports and the clock."""

from __future__ import annotations

from typing import Any

from grip_bt.nodes.control import SKIPPED, Control


class RecoveryNode(Control):
    """The first child; when it fails the second, and then the first again, a number of times."""

    at = retries = 0

    def decide(self) -> str:
        work, recovery = self.below
        while self.retries <= int(self.get("number_of_retries")):
            if self.at == 0:
                end = work.tick()
                if end == "running":
                    return end
                if end != "failure" or self.retries >= int(self.get("number_of_retries")):
                    return self._ended(end)
                work.halt()
                self.at = 1
            end = recovery.tick()
            if end == "running":
                return end
            recovery.halt()
            if end == SKIPPED:  # which doesn't forget how many there were
                self.at = 0
                return "failure"
            if end == "failure":
                return self._ended(end)
            self.at, self.retries = 0, self.retries + 1
        return self._ended("failure")

    def halted(self) -> None:
        self._ended("")

    def _ended(self, end: str) -> str:
        self.at = self.retries = 0
        return end


class PipelineSequence(Control):
    """A sequence whose earlier children are ticked again while a later one runs."""

    def initialise(self) -> None:
        self.furthest = 0

    def decide(self) -> str:
        skips = 0
        for i, child in enumerate(self.below):
            end = child.tick()
            if end == "failure" or (end == "running" and i >= self.furthest):
                self.furthest = i
                return end
            skips += end == SKIPPED
        return SKIPPED if skips == len(self.below) else "success"


class RoundRobin(Control):
    """One child after the other, each time it is entered the next; it fails when all have failed."""

    at = fails = 0

    def decide(self) -> str:
        count, wraps, skips = len(self.below), self.get("wrap_around") in (True, 1, "true", "1"), 0
        while self.fails + skips < count:
            end = self.below[self.at].tick()
            if end == "running":
                return end
            self.at += 1
            over = self.at == count and not wraps
            self.at = self.at % count if wraps else self.at
            if end == "success" and not over:
                self.fails = 0
                return end
            self.fails, skips = self.fails + (end == "failure"), skips + (end == SKIPPED)
            if over:
                break
        self.halted()
        return SKIPPED if skips == count else "failure"

    def halted(self) -> None:
        self.at = self.fails = 0


class RateController(Control):
    """The child at most at a rate; while it runs, on every tick."""

    since: float | None = None

    def initialise(self) -> None:
        if not self.kept:
            self.since = None

    def decide(self) -> str:
        now, period, child = self.context.clock.now(), 1.0 / float(self.get("hz")), self.below[0]
        if self.since is not None and not child.running and now < self.since + period:
            self.context.wake_at(self.since + period)
            return "running"
        self.since = now if self.since is None else self.since
        end = child.tick()
        if end == "success":
            self.since = now
        return end


class GoalUpdatedController(Control):
    """The child at first, and when the goals have changed; while it runs, on every tick."""

    def initialise(self) -> None:
        if not self.kept:
            self.goals: Any = None

    def decide(self) -> str:
        goals, child = (self.get("goal"), self.get("goals")), self.below[0]
        changed, self.goals = goals != self.goals, goals
        return child.tick() if changed or child.running else "running"
