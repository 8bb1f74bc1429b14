"""What a plain client hears of a robot's driver, as one line of JSON: links, frames, the clock, a stamp."""

import json
import sys
import time
import xml.etree.ElementTree as ET

import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

KEPT = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
heard = {}


def frames(name):
    def take(message):
        into = heard.setdefault(name, {})
        for each in message.transforms:
            t, q = each.transform.translation, each.transform.rotation
            into[each.child_frame_id] = [each.header.frame_id, [t.x, t.y, t.z], [q.w, q.x, q.y, q.z]]

    return take


rclpy.init()
node = rclpy.create_node("plain_listener")
node.create_subscription(String, "/robot_description", lambda m: heard.setdefault("robot", m.data), KEPT)
node.create_subscription(TFMessage, "/tf_static", frames("static"), KEPT)
node.create_subscription(TFMessage, "/tf", frames("moving"), 10)
node.create_subscription(Clock, "/clock", lambda m: heard.setdefault("clock", []).append(m.clock.sec), 10)
node.create_subscription(JointState, "/joint_states", lambda m: heard.__setitem__("stamp", m.header.stamp.sec), 10)
end = time.monotonic() + 60
while time.monotonic() < end and not {"robot", "static", "moving", "clock", "stamp"} <= set(heard):
    rclpy.spin_once(node, timeout_sec=0.1)
links = [link.get("name") for link in ET.fromstring(heard["robot"]).findall("link")]
sys.stdout.write(json.dumps({**heard, "robot": links}) + "\n")
sys.stdout.flush()
