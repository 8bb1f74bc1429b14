"""A plain client of services and an action: reads `[type, name, fields]` a line, and answers with JSON."""

import importlib
import json
import sys

import rclpy
from rclpy.action import ActionClient

rclpy.init()
node = rclpy.create_node("plain_service_client")


def loaded(name):
    package, kind, cls = name.split("/")
    return getattr(importlib.import_module(f"{package}.{kind}"), cls)


def fill(message, fields):
    for name, value in fields.items():
        if isinstance(value, dict):
            fill(getattr(message, name), value)
        else:
            setattr(message, name, value)


def plain(value):
    if hasattr(value, "get_fields_and_field_types"):
        return {name: plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, (str, int, float)):
        return value
    return [plain(each) for each in value]


def over(future):
    rclpy.spin_until_future_complete(node, future, timeout_sec=120)
    return future.result()


for line in sys.stdin:
    kind, name, fields = json.loads(line)
    cls = loaded(kind)
    if "/action/" in kind:
        client = ActionClient(node, cls, name)
        assert client.wait_for_server(60)
        goal = cls.Goal()
        fill(goal, fields)
        handle = over(client.send_goal_async(goal))
        answer = {"accepted": handle.accepted}
        if handle.accepted:
            ended = over(handle.get_result_async())
            answer |= {"status": ended.status, **plain(ended.result)}
    else:
        client = node.create_client(cls, name)
        assert client.wait_for_service(60)
        asked = cls.Request()
        fill(asked, fields)
        answer = plain(over(client.call_async(asked)))
    sys.stdout.write(json.dumps(answer) + "\n")
    sys.stdout.flush()
