"""A plain client of services, actions and topics: reads `[type, name, fields]` a line, and answers with JSON.

A message with fields is published when somebody listens; without fields, the next one that comes is the answer.
"""

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
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            package, kind = message.get_fields_and_field_types()[name][len("sequence<") : -1].split("/")
            rows = [loaded(f"{package}/msg/{kind}")() for _ in value]
            for row, each in zip(rows, value, strict=True):
                fill(row, each)
            setattr(message, name, rows)
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


def published(cls, name, fields):
    if name not in publishers:
        publishers[name] = node.create_publisher(cls, name, 10)
    while not publishers[name].get_subscription_count():
        rclpy.spin_once(node, timeout_sec=0.05)
    message = cls()
    fill(message, fields)
    publishers[name].publish(message)
    return {}


def heard(cls, name):
    found = []
    subscription = node.create_subscription(cls, name, found.append, 1)
    while not found:
        rclpy.spin_once(node, timeout_sec=0.05)
    node.destroy_subscription(subscription)
    return plain(found[-1])


publishers = {}
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
    elif "/msg/" in kind:
        answer = published(cls, name, fields) if fields else heard(cls, name)
    else:
        client = node.create_client(cls, name)
        assert client.wait_for_service(60)
        asked = cls.Request()
        fill(asked, fields)
        answer = plain(over(client.call_async(asked)))
    sys.stdout.write(json.dumps(answer) + "\n")
    sys.stdout.flush()
