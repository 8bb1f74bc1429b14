"""How the file makes containers that choose: by a value, by a condition, by a list, by the clock."""

from __future__ import annotations

from typing import Any

from grip_bt.compilers.resolve import Part
from grip_bt.task import model

from .conditions import function_of, value_of
from .layout import Code
from .plan import Plan


def chooser(part: Part, children: list[str], plan: Plan) -> tuple[str, dict[str, Any]] | None:
    """Return class and arguments of a container that chooses; None for every other."""
    node = part.node
    match node:
        case model.Switch(on_value=text, default=default):
            cases: dict[str, list[Any]] = {}
            for child, literal in node.literals():
                cases.setdefault(child, []).append(literal)
            value = value_of(text, part, plan)
            made = "switch", "Switch", {"value": value, "cases": cases, "default": default}
        case model.Loop(while_=text, times=times):
            holds = function_of(text, part, plan) if text else None
            made = "loop", "Loop", {"condition": holds, "times": times}
        case model.ForEach(items=items, item=item):
            seen = plan.visible(part)
            plan.parts.add("variable")
            made = "for_each", "ForEach", {"items": Code(seen[items]), "item": Code(seen[item])}
        case model.Cooldown(seconds=seconds):
            made = "cooldown", "Cooldown", {"seconds": seconds}
        case _:
            return None
    name, class_name, arguments = made
    plan.parts |= {"chooser", name}
    names = [Code(child) for child in children]
    over = {"children": names} if isinstance(node, model.Switch) else {"child": names[0]}
    return class_name, {**over, **arguments}
