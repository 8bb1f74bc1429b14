"""Goals of nodes that are interrupted, or take too long, never overlap on their server, which takes a while to stop."""

from __future__ import annotations

import json
import os
import random

import pytest
from patience import PATIENCE
from ros_bench import ended

from grip_bt.compilers import to_machine, to_tree
from grip_bt.nodes.leaf import OperationLeaf
from grip_bt.runtime import RunContext, Runner
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.model import Task

pytestmark = [pytest.mark.ros, pytest.mark.timeout(3000)]
ROUNDS = int(os.environ.get("GRIP_FUZZ_OVERLAPS", "6"))
FACE = Manifest(id="test/work", doc="Work for a while.", implementation="tests:Working")


class Working(OperationLeaf):
    """Sends a goal; some are given up by the client, as late, some by the task."""

    def start(self):
        draw = self.draw
        goal = self.client.type.Goal(input="finish", seconds=draw.uniform(0.0, 0.3))
        limit = draw.choice((0.05, 0.1, PATIENCE))
        return self.client.send(goal, limit, PATIENCE, cancel_within=PATIENCE)


@pytest.mark.parametrize("target", [to_tree, to_machine])
def test_no_goal_begins_before_the_one_before_has_ended(target, bus, trial, start_server):
    from trial_interfaces.action import Work

    start_server("slow_stopping_server.py", "/slow", "5", overlays=[trial])
    client = bus.action(Work, "/slow")
    ended(client.wait_ready(PATIENCE))
    draw = random.Random(3)

    def made(path, node, manifest):
        leaf = Working(path, path, manifest, {}, {})
        leaf.client, leaf.draw = client, draw
        return leaf

    def tried(seconds):
        return {"kind": "timeout", "seconds": seconds, "child": {"w": {"node": "test/work"}}}

    either = {f"c{k}": tried(seconds) for k, seconds in enumerate((0.04, 0.15, 0.3, 5.0))}
    either["last"] = {"kind": "sequence", "children": {}}
    root = {"kind": "repeat", "times": ROUNDS, "child": {"e": {"kind": "fallback", "children": either}}}
    task = Task.model_validate({"grip": 1, "name": "many", "root": root})
    compiled = target(task, Catalog([FACE]), leaf_factory=made)
    result = Runner(compiled, RunContext(), poll=0.01).run()
    assert (result.status, result.zombies) == ("success", ())
    counts = json.loads(ended(bus.service("std_srvs/srv/Trigger", "/slow/counts").call(_empty())).message)
    assert counts["goals"] >= ROUNDS
    assert counts["canceled"] > 0
    assert counts["overlaps"] == 0


def _empty():
    from std_srvs.srv import Trigger

    return Trigger.Request()
