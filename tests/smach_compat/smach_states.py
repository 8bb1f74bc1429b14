"""States that the smach tests share."""

import threading

from grip_bt.smach_compat import State


class Returns(State):
    """Ends with the next of some outcomes, the last one again and again; counts its runs."""

    def __init__(self, *returned, outcomes=None, **keys):
        super().__init__(list(dict.fromkeys(returned)) if outcomes is None else outcomes, **keys)
        self.returned, self.runs = returned, 0

    def execute(self, ud):
        self.runs += 1
        return self.returned[min(self.runs, len(self.returned)) - 1]


def ok(**keys):
    """Return a state that ends with its only outcome, `ok`."""
    return Returns("ok", **keys)


class Does(State):
    """Calls `work(userdata)`; ends with what that returns, or `ok`."""

    def __init__(self, work, outcomes=("ok",), **keys):
        super().__init__(list(outcomes), **keys)
        self.work = work

    def execute(self, ud):
        result = self.work(ud)
        return "ok" if result is None else result


def raises(error):
    """Return a state that raises."""

    def work(ud):
        raise error

    return Does(work)


class WaitsForPreempt(State):
    """Blocks until a preempt is requested; ends with `pre`."""

    def __init__(self, services=True):
        super().__init__(["pre"])
        self.services, self.begun, self._asked = services, threading.Event(), threading.Event()

    def request_preempt(self):
        super().request_preempt()
        self._asked.set()

    def execute(self, ud):
        self.begun.set()
        assert self._asked.wait(120), "no preempt came"
        if self.services:
            self.service_preempt()
        return "pre"


class Preemptable(State):
    """Ends with `preempted` when it sees the flag, else `ok`; notes what it saw."""

    def __init__(self, services):
        super().__init__(["ok", "preempted"])
        self.services, self.seen = services, []

    def execute(self, ud):
        self.seen.append(self.preempt_requested())
        if not self.preempt_requested():
            return "ok"
        if self.services:
            self.service_preempt()
        return "preempted"
