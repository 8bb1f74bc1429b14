"""A world in which a goal can go wrong in every way, in simulated time: server, wire, owner, all from a seed."""

from __future__ import annotations

import heapq
import random
from dataclasses import dataclass, field
from itertools import count

from grip_bt.base.failures import ExpectedError
from grip_bt.ros.client.goal import Ask, Goal, GoalEnd, GoalTimeouts, Notify, Phase

POLL = 0.05
ACCEPTED, SUCCEEDED, CANCELED, ABORTED, UNKNOWN = 1, 4, 5, 6, 0
NAMED = {"server_lost", "timed_out", "rejected", "canceled"}


@dataclass
class Work:
    """A goal as the server has it."""

    until: float
    status: int
    stubborn: bool
    asked: bool = False
    told_to_stop: bool = False
    ended: int | None = None


@dataclass
class Outcome:
    """What the owner was told, and what was left behind."""

    told: list = field(default_factory=list)
    at: float = 0.0
    orphan: bool = False
    history: list = field(default_factory=list)


class World:
    """One race. A server that dies forgets everything; one that doesn't know the client's ear yet answers in vain."""

    def __init__(self, seed: int):
        self.random = random.Random(seed)
        self.now, self.queue, self.order = 0.0, [], count()
        draw = self.random.random
        patience = GoalTimeouts(
            result=self.random.choice((0.3, 1.5, 20.0)),
            cancel=self.random.choice((0.2, 1.0)),
            gone=self.random.choice((0.0, 0.3)),
        )
        self.patience, self.goal, self.result = patience, Goal("/act", patience, 0.0, 0.0), Outcome()
        self.alive, self.incarnation, self.sent_to = False, 0, None
        self.supervised = draw() < 0.3
        self.lag = self.random.choice((0.001, 0.02, 0.3))
        self.notice = self.random.choice((0.0, 0.1, 3.0))  # how long DDS takes to see a death
        self.died_at = -10.0
        self.work: Work | None = None
        self.rejects = draw() < 0.1
        self.loses_goal = draw() < 0.05
        self.loses_acceptance = draw() < 0.3
        self.hides_status = draw() < 0.5
        self.drops_cancels = self.random.choice((0.0, 0.0, 0.3))
        self.takes_when_heard = draw() < 0.5  # else a cancel that comes while the server thinks finds no goal
        self._plan(draw)

    def _plan(self, draw) -> None:
        self._start()
        self.sent_to = self.incarnation
        self.wire(self._take_goal)
        for _ in range(self.random.choice((0, 0, 1, 2))):
            when = draw() * self.random.choice((0.1, 1.0, 3.0))
            self.at(when, self._die)
            if draw() < 0.7:
                self.at(when + draw(), self._start)
        if draw() < 0.6:
            self.at(draw() * self.random.choice((0.01, 0.2, 2.0)), self._cancel)
        if draw() < 0.1:
            self.at(draw() * 2.0, lambda: self.do(self.goal.close(self.now)))

    # --- the clockwork ---

    def at(self, delay: float, do) -> None:
        heapq.heappush(self.queue, (self.now + delay, next(self.order), do))

    def run(self) -> Outcome:
        self.at(0.0, self._poll)
        while self.queue and self.now < 90.0:
            self.now, _, do = heapq.heappop(self.queue)
            do()
        left = self.alive and self.work is not None and self.work.ended is None
        self.result.orphan = left and not self.work.told_to_stop
        return self.result

    def do(self, commands) -> None:
        for command in commands:
            self.result.history.append((round(self.now, 3), type(command).__name__, self.goal.phase.name))
            match command:
                case Ask.RESULT:
                    self.wire(self._want_result)
                case Ask.CANCEL:
                    self.wire(self._hear_cancel)
                case Notify(end):
                    self.result.told.append(end)
                    self.result.at = self.now

    def wire(self, do, to_client: bool = False) -> None:
        incarnation = self.incarnation

        def arrive() -> None:
            if to_client or (self.alive and self.incarnation == incarnation):
                do()

        self.at(self.random.random() * self.lag, arrive)

    # --- the client ---

    def _poll(self) -> None:
        there = self.alive and self.incarnation == self.sent_to
        self.do(self.goal.server_seen(there or self.now < self.died_at + self.notice, self.now))
        if there and self.work is not None and not self.hides_status:
            self.do(self.goal.status(self.work.ended or ACCEPTED, self.now))
        self.do(self.goal.tick(self.now))
        if self.goal.phase is not Phase.OVER:
            self.at(POLL, self._poll)

    def _cancel(self) -> None:
        self.canceled_at = self.now
        self.do(self.goal.cancel(self.now))

    # --- the server ---

    def _start(self) -> None:
        if not self.alive:
            self.alive, self.work, self.incarnation = True, None, self.incarnation + 1

    def _die(self) -> None:
        if self.alive:
            self.alive, self.died_at = False, self.now
            if self.supervised:
                self.at(0.01, lambda: self.do(self.goal.server_ended("the process ended")))

    def _take_goal(self) -> None:
        if self.loses_goal:
            return
        if self.rejects:
            self.wire(lambda: self.do(self.goal.rejected()), to_client=True)
            return
        draw = self.random
        lasts, status = draw.choice((0.0, 0.05, 1.0, 100.0)), draw.choice((SUCCEEDED, SUCCEEDED, ABORTED))
        stubborn, thinks, mine = draw.random() < 0.2, draw.choice((0.0, 0.0, 0.5, 5.0)), self.incarnation

        def take() -> None:
            if self.alive and self.incarnation == mine:
                self.work = work = Work(self.now + lasts, status, stubborn)
                self.at(lasts, lambda: self._end(work, status))

        def answer() -> None:
            if self.alive and self.incarnation == mine and not self.loses_acceptance:
                self.wire(lambda: self.do(self.goal.accepted(self.now)), to_client=True)

        self.at(0.0 if self.takes_when_heard else thinks, take)
        self.at(thinks, answer)

    def _want_result(self) -> None:
        if self.random.random() < 0.1:
            return  # dropped: too many at once
        if self.work is None:
            self.wire(lambda: self.do(self.goal.result(UNKNOWN, None)), to_client=True)
            return
        self.work.asked = True
        if self.work.ended is not None:
            self._answer(self.work)

    def _hear_cancel(self) -> None:
        work = self.work
        takes = work is not None and work.ended is None and not work.stubborn
        stops, known = takes or (work is not None and work.ended is not None), work is not None
        if work is not None:
            work.told_to_stop = True
        if takes:
            self.at(self.random.choice((0.0, 0.1, 3.0)), lambda: self._end(work, CANCELED))
        if self.random.random() >= self.drops_cancels:
            self.wire(lambda: self.do(self.goal.cancel_answered(stops, known, self.now)), to_client=True)

    def _end(self, work: Work, status: int) -> None:
        if work is self.work and self.alive and work.ended is None:
            work.ended = status
            if work.asked:
                self._answer(work)

    def _answer(self, work: Work) -> None:
        self.wire(lambda: self.do(self.goal.result(work.ended, "result")), to_client=True)


def race(seed: int) -> Outcome:
    """Run one race and check what must hold in every one."""
    world = World(seed)
    outcome = world.run()
    assert len(outcome.told) == 1, f"seed {seed}: told {len(outcome.told)} times: {outcome}"
    (told,) = outcome.told
    patience = world.patience
    latest = patience.result + patience.cancel + 2 * POLL
    assert outcome.at <= latest, f"seed {seed}: told only after {outcome.at:.2f} s, at most {latest:.2f}: {outcome}"
    if isinstance(told, GoalEnd):
        assert told.status in ("succeeded", "aborted", "canceled")
    else:
        assert isinstance(told, ExpectedError), told
        assert told.code in NAMED, f"seed {seed}: {told!r}"
    assert not outcome.orphan, f"seed {seed}: the server works on for nobody: {outcome}"
    assert world.goal.phase is Phase.OVER, f"seed {seed}: {world.goal.phase}"
    return outcome
