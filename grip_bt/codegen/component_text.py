"""A first component file, as a person would write it, from an interface and the few words that it doesn't say."""

from __future__ import annotations

import re
from collections.abc import Collection

from grip_bt.catalog.component_file import ComponentFile
from grip_bt.catalog.interface_spec import FieldSpec, InterfaceSpec
from grip_bt.errors import GripError

from .contract import INPUT, OUTCOME, RETURNED

VALUES = {
    "geometry_msgs/msg/PoseStamped": "Pose",
    "geometry_msgs/msg/Pose": "Pose",
    "geometry_msgs/msg/TransformStamped": "Pose",
    "sensor_msgs/msg/PointCloud2": "PointCloud",
    "sensor_msgs/msg/Image": "Image",
    "sensor_msgs/msg/CameraInfo": "CameraInfo",
    "sensor_msgs/msg/JointState": "JointState",
    "trajectory_msgs/msg/JointTrajectory": "Trajectory",
}
"""Messages that have a value of GRIP's own."""


class OutcomesNeededError(GripError):
    """An interface doesn't say how its software can end; `suggestion` is what could be given."""

    def __init__(self, interface: InterfaceSpec):
        self.suggestion = suggested_outcomes(interface)
        if keeps_contract(interface):
            what = "its result numbers an outcome, but how many there are, and what they are called, isn't said"
        else:
            what = "it has no field `outcome`, so its outcomes are given by rule, over its fields"
        super().__init__(f"{interface.type_name}: {what}; for instance: --outcomes {self.suggestion!r}")


def keeps_contract(interface: InterfaceSpec) -> bool:
    """Tell whether the three fields are there."""
    response = {f.name: f for f in interface.response}
    has_input = any(f.name == INPUT for f in interface.request)
    return has_input and RETURNED in response and OUTCOME in response and response[OUTCOME].is_integer


def suggested_outcomes(interface: InterfaceSpec) -> str:
    """Return outcomes that would be possible, as `--outcomes` takes them."""
    if keeps_contract(interface):
        return "done,failed"
    flag = next((f for f in interface.response if f.type == "bool" and not f.array), None)
    if flag is not None:
        return f"done: {flag.name}; failed: not {flag.name}"
    several = next((f for f in interface.response if f.array), None)
    return f"found: len({several.name}) > 0; none: true" if several is not None else "done: true"


def parse_outcomes(text: str) -> int | list[str] | dict[str, str]:
    """Read what `--outcomes` takes: a number, names in the order of their numbers, or `label: rule; label: rule`.

    Raises:
        GripError: it is none of these.
    """
    text = text.strip()
    if text.isdigit():
        return int(text)
    if ":" in text:
        pairs = [part.partition(":") for part in text.split(";") if part.strip()]
        if any(not rule.strip() for _, _, rule in pairs):
            raise GripError(
                f"--outcomes {text!r}: write `label: rule; label: rule`, such as `found: count > 0; none: true`"
            )
        return {label.strip(): rule.strip() for label, _, rule in pairs}
    names = [name.strip() for name in text.split(",")]
    if not all(re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name) for name in names):
        raise GripError(
            f"--outcomes {text!r}: write names such as `one,several,none`, a number, or rules `label: rule; ...`"
        )
    return names


def component_text(
    interface: InterfaceSpec,
    name: str,
    server: str,
    outcomes: int | list[str] | dict[str, str],
    failures: Collection[str],
) -> str:
    """Return the text of `component.yaml`.

    Raises:
        ValueError: something doesn't fit (pydantic's own, which names it).
    """
    meaning = dict.fromkeys(failures, "failure")
    ports = {f.name: _port(f) for f in (*interface.request, *interface.response) if _port(f)}
    data = {"name": name, "interface": interface.type_name, "server": server, "outcomes": outcomes, "meaning": meaning}
    ComponentFile.model_validate({**data, "ports": ports})
    lines = [f"name: {name}"]
    lines += [f"doc: {_quoted(interface.doc)}"] if interface.doc else []
    lines += [f"interface: {interface.type_name}", f"server: {server}"]
    if isinstance(outcomes, dict):
        lines += ["outcomes:", *(f"  {label}: {_quoted(rule)}" for label, rule in outcomes.items())]
    elif isinstance(outcomes, list):
        lines += [f"outcomes: [{', '.join(outcomes)}]      # the numbers 0, 1, 2 ... of the field `outcome`"]
    else:
        lines += [f"outcomes: {outcomes}      # how many; they are called outcome_0 and so on"]
    if meaning:
        lines += [f"meaning: {{{', '.join(f'{label}: failure' for label in meaning)}}}"]
    if ports:
        lines += ["ports:", *(f'  {port}: "{type_}"' for port, type_ in ports.items())]
    lines += ["# start:", '#   command: ["{python}", server.py]     # how to start it; without, it is expected to run']
    return "\n".join(lines) + "\n"


def _port(field: FieldSpec) -> str:
    value = VALUES.get(field.type, "")
    return f"list[{value}]" if value and field.array else value


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
