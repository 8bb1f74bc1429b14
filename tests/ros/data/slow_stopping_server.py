"""An action server that takes a while to stop: `slow_stopping_server.py NAME SEED`.

A goal works for its `seconds`, or, once it is told to stop, for a random while more. How many goals there were, and how
many began while another one was at work, the service `NAME/counts` tells as JSON.
"""

import json
import random
import sys
import threading
import time

import rclpy
from rclpy.action import ActionServer, CancelResponse
from rclpy.executors import MultiThreadedExecutor
from std_srvs.srv import Trigger
from trial_interfaces.action import Work

name, draw = sys.argv[1], random.Random(int(sys.argv[2]))
counts = {"goals": 0, "overlaps": 0, "canceled": 0}
working, lock = [], threading.Lock()


def work(handle):
    with lock:
        counts["goals"] += 1
        counts["overlaps"] += bool(working)
        working.append(handle)
    deadline, told = time.monotonic() + handle.request.seconds, False
    while time.monotonic() < deadline:
        time.sleep(0.002)
        if handle.is_cancel_requested and not told:
            told, deadline = True, time.monotonic() + draw.uniform(0.0, 0.15)
    with lock:
        working.remove(handle)
        counts["canceled"] += told
    handle.canceled() if told else handle.succeed()
    return Work.Result()


def tell(_, answer):
    answer.message = json.dumps(counts)
    return answer


rclpy.init()
node = rclpy.create_node("slow_to_stop")
server = ActionServer(node, Work, name, work, cancel_callback=lambda _: CancelResponse.ACCEPT)
node.create_service(Trigger, f"{name}/counts", tell)
executor = MultiThreadedExecutor(6)
executor.add_node(node)
sys.stdout.write("serving\n")
sys.stdout.flush()
executor.spin()
