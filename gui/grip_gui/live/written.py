"""Values as YAML that people change: joint states and poses as in a project's files, messages field by field."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from ruamel.yaml import YAML

from grip_bt.errors import DocumentError, GripError
from grip_bt.graph.syntax import parse, plain
from grip_bt.messages.original import read_joint_states, read_poses
from grip_bt.values import JointState, Pose

DIGITS = 9


def text_of(value: Any, plain_of: Callable[[Any], Any] = lambda _: None) -> str:
    """Return a value as YAML; empty for what isn't changed by hand.

    Args:
        value: a joint state, a pose, or a message.
        plain_of: makes plain data of a message; None of what is too much.
    """
    match value:
        case JointState():
            data: Any = _numbers(value.names, value.position)
        case Pose():
            data = {
                "reference_frame": value.frame,
                "position": _numbers("xyz", value.position),
                "orientation": _numbers("xyzw", np.roll(value.quaternion, -1)),
            }
        case _:
            data = plain_of(value) if hasattr(value, "get_fields_and_field_types") else None
    if data is None:
        return ""
    out, yaml = io.StringIO(), YAML(typ="safe")
    yaml.default_flow_style, yaml.sort_base_mapping_type_on_output = False, False  # type: ignore[assignment]
    yaml.dump(data, out)
    return out.getvalue()


def value_of(store: str, name: str, text: str) -> Any:
    """Return what a text says: a joint state or a pose for these stores, else a mapping of a message's fields.

    Raises:
        DocumentError: it says something else, with the place.
    """
    data = plain(parse(text, name))
    if not isinstance(data, dict) or not data:
        raise DocumentError("a mapping is expected, such as `joint_1: 0.5` or a message's fields", name, 1, 1)
    if store not in ("joint_states", "poses"):
        return data
    lines = "".join(f"  {line}\n" for line in text.splitlines())
    with TemporaryDirectory() as folder:
        file = Path(folder) / f"{store}.yaml"
        file.write_text(f"value:\n{lines}", encoding="utf-8")
        try:
            return read_joint_states(file)["value"] if store == "joint_states" else read_poses(file)[0]["value"]
        except DocumentError as error:
            line = max(1, error.line - 1) if error.line else None
            raise DocumentError(error.message.replace("value: ", ""), name, line, error.column) from None
        except KeyError:
            raise GripError(f"{name}: one pose is expected, with position and orientation") from None


def _numbers(names: Any, values: Any) -> dict[str, float]:
    return {str(name): round(float(number), DIGITS) for name, number in zip(names, np.asarray(values), strict=True)}
