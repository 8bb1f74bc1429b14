"""Begins a long motion in a process of its own, as a run does: `mover.py trajectory|topic DOMAIN [threads]`."""

import sys
import time

import numpy as np

from grip_bt.base.values import Trajectory
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.controllers import JointStates, TopicExecutor, TrajectoryExecutor

NAMES = ("joint_a", "joint_b")
way, domain = sys.argv[1], int(sys.argv[2])
bus = Bus("mover", domain, watched=True)
bus.watchdog.watch_joints("arm", "/joint_states", NAMES, ["/arm/follow_joint_trajectory"])
states = JointStates(bus, stale=400.0)
states.wait_for(NAMES, 400.0)
if way == "topic":
    executor = TopicExecutor(bus, "/arm/joint_trajectory", NAMES, states)
else:
    executor = TrajectoryExecutor(bus, "/arm/follow_joint_trajectory", NAMES, states, wait=400.0)
sys.stdout.write("ready\n")
sys.stdout.flush()
sys.stdin.readline()
start = states.state(NAMES).position
part = np.linspace(0.0, 1.0, 51)[:, None]
executor.execute(Trajectory(NAMES, part[:, 0] * 600.0, start + part * 2.5))
sys.stdout.write("begun\n")
sys.stdout.flush()
time.sleep(2000.0)
