"""`python -m grip_gui.live.trying`: a project's parts, tried in a process of their own.

Asked with `folder` and `given` (port -> `{run, seq}`, `{store, name}` or `{text}`) it starts the component there and
calls it once; its answer is a `TryView`. Else it is asked what `measured` takes, and answers with `text`, in YAML.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from grip_bt.app.project.components import label_of
from grip_bt.app.project.folder import Project, find_project
from grip_bt.app.project.foreign_code import of_component, refuse
from grip_bt.app.wiring.open import open_resources
from grip_bt.app.wiring.parts import Opening
from grip_bt.base.errors import DocumentError, GripError, MissingPartError, UnknownNameError
from grip_bt.base.message_store import MessageLibrary
from grip_bt.base.message_store.text import fields_of, text_of
from grip_bt.base.ports import Arm, Hand
from grip_bt.base.values import JointState, Pose
from grip_bt.base.yaml.tree import parse, to_data
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.runtime import JournalReader
from grip_bt.task.catalog.component_file import ComponentFile, load_component
from grip_gui.processes import answer_question
from grip_gui.setup.settings_store import DIGITS
from grip_gui.wire.live import TryView


def tried(folder: Path, given: Mapping[str, Mapping[str, Any]]) -> TryView:
    """Return how the component in a folder answers; port -> where its value is.

    Raises:
        GripError: it can't be started, or a value isn't there.
        ExpectedError: it doesn't answer, or answers what it may not.
    """
    from grip_bt.ros.components import start_components  # here, since robots are measured without ROS too
    from grip_gui.live.message_view import message_view

    component, project = load_component(folder), find_project(folder)
    refuse(of_component(folder))
    request = {port: _value(project, component, port, source) for port, source in given.items()}
    with start_components(project.folder, [component.name], folder=folder.parent) as components:
        built = f", its interfaces built in {components.build_seconds:.1f} s" if components.build_seconds else ""
        began = time.perf_counter()
        operation = components.client(component.name).call(request)
        operation.wait(component.timeouts.call + component.timeouts.ready + 1)
        reply = operation.result()
        spent = (time.perf_counter() - began) * 1e3
        ready = f"{component.server} was ready after {components.ready_seconds:.2f} s{built}"
    fields = {}
    for name, value in reply.items():
        declared = component.ports.get(name)
        type_name = declared.type if declared is not None and fields_of(value) is None else type(value).__name__
        fields[name] = message_view(type_name, value)
    return TryView(outcome=label_of(component, reply), fields=fields, milliseconds=spent, started=ready)


def _value(project: Project, component: ComponentFile, port: str, source: Mapping[str, Any]) -> Any:
    if "seq" in source:
        with JournalReader(project.journal) as reader:
            events = reader.events(source["run"], source["seq"] - 1, 1)
            if not events or events[0].event != "write":
                raise GripError(f"{port}: the run {source['run']} has no write {source['seq']}")
            return reader.value(events[0])
    if "store" in source:
        return MessageLibrary(project.folder / "messages").store(source["store"]).get(source["name"])
    declared = component.ports.get(port)
    return typed(source["text"], declared.type if declared is not None else "Any", port)


def typed(text: str, type_name: str, port: str) -> Any:
    """Return what a person has typed for an input, in YAML.

    That is a number, a text, a list, the fields of a message, `{position, quaternion, frame}` of a pose, or
    `{joint: position}` of a joint state.

    Raises:
        DocumentError: it isn't YAML, or no value of the type.
    """
    data = to_data(parse(text, port))
    try:
        if isinstance(data, dict) and type_name == "Pose" and isinstance(data.get("position"), list):
            return Pose(**data)
        if isinstance(data, dict) and type_name == "JointState" and "position" not in data:
            return JointState.from_mapping(data)
    except (TypeError, ValueError) as error:
        raise DocumentError(f"no {type_name}: {error}", port, 1, 1) from None
    return data


_NO_ARM = "{} is a hand: its joints can be kept; the pose of its palm is the arm's"


def measured(robot: str, part: str, what: str, joints: Mapping[str, float] | None = None) -> Any:
    """Return where an arm or a hand of this folder's project is, by the robot's adapters as a run gets them.

    Args:
        robot: `fake`, `sim` (which starts a world, and measures where its robot begins) or `ros`.
        part: an arm, or a hand.
        what: `joints`, or `pose` of the arm's grasp frame.
        joints: with `robot` `run`, where the part's joints were measured [rad or m].

    Raises:
        GripError: it can't be measured; the message says why.
    """
    project = find_project(Path.cwd())
    if project.file.robot is None:
        raise MissingPartError("a robot", "name one in grip.yaml (`robot:`)")
    if joints is not None:
        state = JointState.from_mapping(joints)
        if what == "joints":
            return state
        if part not in project.file.arms:
            raise GripError(_NO_ARM.format(part))
        return RobotModel(project.description()).grasp_pose(state, group=project.file.arms[part].group)
    with open_resources(Opening(project), ["arm/teach"], robot) as resources:
        parts: dict[str, Arm | Hand] = {**resources.hands, **resources.arms}
        if part not in parts:
            raise UnknownNameError("arm or hand", part, parts, "grip.yaml")
        if what == "pose":
            if part not in resources.arms:
                raise GripError(_NO_ARM.format(part))
            return resources.arms[part].grasp_pose()
        return parts[part].state()


def _answer(**question: Any) -> Mapping[str, Any]:
    if "given" in question:
        return tried(Path(question["folder"]), question["given"]).model_dump(mode="json")
    return {"text": text_of(measured(**question), DIGITS)}


if __name__ == "__main__":
    sys.exit(answer_question(_answer))
