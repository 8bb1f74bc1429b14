"""What people do to a tree between two ticks; the same to both trees of a pair."""

from __future__ import annotations

import random
from typing import Any

from engine_leaves import INVALID, F, Log, R, S
from engine_trees import Maker
from py_trees import composites, decorators
from py_trees.behaviour import Behaviour
from py_trees.common import Status

VALUES = [S, F, R]


def edit(root: Behaviour, seed: int, log: Log, *, fixed: bool = False) -> None:
    """Do one thing, chosen by `seed`, to the tree; where it is fixed, only its statuses change."""
    rng = random.Random(seed)
    nodes = list(root.iterate())
    node: Any = rng.choice(nodes)
    if rng.random() < 0.3:
        node = root
    draw = rng.randrange(5 if fixed else 12)
    maker = Maker(seed, log)
    maker.made = 1000 + seed % 1000
    if draw < 3:
        node.stop(INVALID)
    elif draw == 3:
        node.status = rng.choice(list(Status))
    elif draw == 4:
        node.tick_once()
    elif draw < 8:
        _children(node, rng, maker)
    elif draw == 8:
        _settings(node, rng)
    else:
        _method(node, rng, log)


def _children(node: Any, rng: random.Random, maker: Maker) -> None:
    if isinstance(node, decorators.Decorator):
        fresh = maker.leaf()
        fresh.parent = node
        node.decorated.parent = None
        node.decorated = node.children[0] = fresh
    elif isinstance(node, composites.Composite):
        fresh = maker.tree(1)
        kids = node.children
        draw = rng.randrange(5)
        if draw == 0 or not kids:
            node.insert_child(fresh, rng.randint(0, len(kids)))
        elif draw == 1:
            node.remove_child(rng.choice(kids))
        elif draw == 2:
            node.replace_child(rng.choice(kids), fresh)
        elif draw == 3:
            node.children = list(reversed(kids))
        else:
            node.prepend_child(fresh)


def _settings(node: Any, rng: random.Random) -> None:
    if hasattr(node, "memory"):
        node.memory = not node.memory
    elif hasattr(node, "policy") and isinstance(node, composites.Parallel):
        if rng.random() < 0.5:
            node.policy = Maker(rng.randrange(1000), Log()).policy(node.children)
        else:
            node.policy.synchronise = not node.policy.synchronise
    elif hasattr(node, "num_failures"):
        node.num_failures += 1
    else:
        node.feedback_message = "edited"


def _method(node: Any, rng: random.Random, log: Log) -> None:
    name = rng.choice(["update", "initialise", "terminate", "stop", "tick"])
    if name in vars(node):
        delattr(node, name)
        return
    value, original = rng.choice(VALUES), getattr(node, name)
    if name == "update":

        def patched(*args: Any) -> Any:
            log.append(("patched update", node.name, node.status))
            return value

    elif name == "tick":

        def patched(*args: Any) -> Any:
            log.append(("patched tick", node.name, node.status))
            yield from original()

    else:

        def patched(*args: Any) -> Any:
            log.append((f"patched {name}", node.name, node.status, *args))
            return original(*args)

    setattr(node, name, patched)
