"""Has a goal of `/work` under way, as a run does: `caller.py component|state DOMAIN FOLDER INPUT LIMIT`.

Its watchdog goes on for LIMIT seconds after its death.
"""

import sys
import threading
import time

import grip_bt.ros.watchdog

way, domain, folder, text = sys.argv[1], int(sys.argv[2]), sys.argv[3], sys.argv[4]
grip_bt.ros.watchdog.LIMIT = float(sys.argv[5])


def by_component():
    """Call a component of the project in the folder."""
    from grip_bt.ros.components import start_components

    worker = start_components(folder, ["worker"], domain).client("worker")
    return lambda: worker.call({"input": text, "seconds": 600.0})


def by_state():
    """Execute a state with the connection of its own that legacy states make."""
    from trial_interfaces.action import Work

    from grip_bt.smach_compat import smach_ros

    state = smach_ros.SimpleActionState("/work", Work, goal=Work.Goal(input=text, seconds=600.0))
    return threading.Thread(target=state.execute, args=({},), daemon=True).start


begin = by_component() if way == "component" else by_state()
sys.stdout.write("ready\n")
sys.stdout.flush()
sys.stdin.readline()
begin()
sys.stdout.write("begun\n")
sys.stdout.flush()
time.sleep(2000.0)
