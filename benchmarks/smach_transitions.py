"""Transitions per second of a two-state ping-pong, without userdata and with one key read and one written a state.

    .venv/bin/python benchmarks/smach_transitions.py [--upstream PATH/executive_smach/smach/src]

With a checkout of upstream the same machines are measured on it too, in turns with ours. Loggers do nothing. Time is
CPU time; "best" is the figure to compare on a machine that does other things as well.
"""

import argparse
import gc
import importlib
import statistics
import sys
import time

from grip_bt import smach_compat

TRANSITIONS = 20_000


def ping_pong(smach, with_data):
    """Return a machine of two states that lead to each other until `TRANSITIONS` are over."""

    class Ping(smach.State):
        def __init__(self):
            keys = {"input_keys": ["i"], "output_keys": ["o"]} if with_data else {}
            super().__init__(["go", "done"], **keys)
            self.left = TRANSITIONS // 2

        def execute(self, ud):
            self.left -= 1
            return "go" if self.left else "done"

    class PingData(Ping):
        def execute(self, ud):
            ud.o = ud.i + 1
            self.left -= 1
            return "go" if self.left else "done"

    state = PingData if with_data else Ping
    machine = smach.StateMachine(["done"])
    machine.userdata.a = 0
    with machine:
        smach.StateMachine.add("A", state(), {"go": "B"}, {"i": "a", "o": "b"})
        smach.StateMachine.add("B", state(), {"go": "A"}, {"i": "b", "o": "a"})
    return machine


def rate(smach, with_data):
    """Return the transitions per second [1/s of CPU time] of one execution."""
    smach.set_loggers(*[lambda text: None] * 4)
    machine = ping_pong(smach, with_data)
    gc.collect()
    begin = time.process_time()
    outcome = machine.execute()
    seconds = time.process_time() - begin
    assert outcome == "done"
    if with_data:
        assert machine.userdata.a + machine.userdata.b > TRANSITIONS
    return TRANSITIONS / seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--upstream", help="folder that holds upstream's package `smach`")
    parser.add_argument("--repeats", type=int, default=100)
    args = parser.parse_args()
    packages = {"smach_compat": smach_compat}
    if args.upstream:
        sys.path.insert(0, args.upstream)
        packages["upstream"] = importlib.import_module("smach")
    print(f"{'package':14}{'userdata':12}{'best [M/s]':>12}{'median [M/s]':>14}")
    for with_data in (False, True):
        rates = {name: [] for name in packages}
        for _ in range(args.repeats):
            for name, smach in packages.items():
                rates[name].append(rate(smach, with_data))
        for name, values in rates.items():
            best, median = max(values) / 1e6, statistics.median(values) / 1e6
            label = "in and out" if with_data else "none"
            print(f"{name:14}{label:12}{best:12.2f}{median:14.2f}")


if __name__ == "__main__":
    main()
