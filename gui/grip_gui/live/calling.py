"""`python -m grip_gui.live.calling`: starts a component, calls it once, and tells its answer field by field.

It is asked for `folder`, and `given`: port -> `{run, seq}`, `{store, name}` or `{text}`; its answer is a `TryView`.
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
from grip_bt.base.errors import DocumentError, GripError
from grip_bt.base.message_store import MessageLibrary
from grip_bt.base.message_store.yaml import fields_of
from grip_bt.base.values import JointState, Pose
from grip_bt.base.yaml.tree import parse, to_data
from grip_bt.ros.components import start_components
from grip_bt.runtime import JournalReader
from grip_bt.task.catalog.component_file import ComponentFile, load_component
from grip_gui.live.inspector import message_view
from grip_gui.processes import answer_question
from grip_gui.wire.live import FieldResult, TryView


def tried(folder: Path, given: Mapping[str, Mapping[str, Any]]) -> TryView:
    """Return how the component answers.

    Args:
        folder: of the component.
        given: port -> where its value is.

    Raises:
        GripError: it can't be started, or a value isn't there.
        ExpectedError: it doesn't answer, or answers what it may not.
    """
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
    fields = []
    for name, value in reply.items():
        declared = component.ports.get(name)
        type_name = declared.type if declared is not None and fields_of(value) is None else type(value).__name__
        fields.append(FieldResult(name=name, value=message_view(type_name, value)))
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
    """Return what a person has typed for an input.

    Args:
        text: YAML: a number, a text, a list, the fields of a message, `{position, quaternion, frame}` of a pose, or
            `{joint: position}` of a joint state.
        type_name: the declared type.
        port: for the message of an error.

    Raises:
        DocumentError: it isn't YAML, or no value of the type.
    """
    data = to_data(parse(text, port))
    if not isinstance(data, dict):
        return data
    try:
        if type_name == "Pose" and isinstance(data.get("position"), list):
            return Pose(**data)
        if type_name == "JointState" and "position" not in data:
            return JointState.from_mapping(data)
    except (TypeError, ValueError) as error:
        raise DocumentError(f"no {type_name}: {error}", port, 1, 1) from None
    return data


if __name__ == "__main__":
    sys.exit(answer_question(lambda folder, given: tried(Path(folder), given).model_dump(mode="json")))
