"""What a new component begins with: its first component file, and a repository in Python or C++ that works."""

from __future__ import annotations

import re
from collections.abc import Collection
from pathlib import Path
from typing import Literal

from grip_bt.base.errors import GripError, ProjectExistsError
from grip_bt.base.yaml.scalars import quoted
from grip_bt.task.catalog.component_file import ComponentFile
from grip_bt.task.catalog.ros_config import FieldSpec, InterfaceSpec

from .contract import VALUE_OF, keeps_contract, suggested_outcomes


class OutcomesNeededError(GripError):
    """An interface doesn't say how its software can end; `suggestion` is what could be given."""

    def __init__(self, interface: InterfaceSpec):
        self.suggestion = suggested_outcomes(interface)
        if keeps_contract(interface):
            what = "its result numbers an outcome, but their number and names are not declared"
        else:
            what = "it has no field `outcome`, so its outcomes are given by rule, over its fields"
        super().__init__(f"{interface.type_name}: {what}; for instance: --outcomes {self.suggestion!r}")


def suggested_name(interface: InterfaceSpec) -> str:
    """Return a component's name made from its interface's: `plan_grasp` of PlanGrasp, `http_grasp` of HTTPGrasp."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", interface.name).lower()


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
        labels = [label.strip() for label, _, _ in pairs]
        if twice := sorted({label for label in labels if labels.count(label) > 1}):
            advice = "an outcome has one rule; join what belongs together by `or`"
            raise GripError(f"--outcomes {text!r}: {', '.join(twice)} is named twice: {advice}")
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
    lines += [f"doc: {quoted(interface.doc)}"] if interface.doc else []
    lines += [f"interface: {interface.type_name}", f"server: {server}"]
    if isinstance(outcomes, dict):
        lines += ["outcomes:", *(f"  {label}: {quoted(rule)}" for label, rule in outcomes.items())]
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
    value = VALUE_OF.get(field.type, "")
    return f"list[{value}]" if value and field.array else value


Language = Literal["python", "cpp"]
_TEMPLATES = Path(__file__).with_name("repository")
_NAME, _CAMEL = "component_name", "ComponentName"


def make_repository(folder: Path, name: str, language: Language) -> list[Path]:
    """Write a component that works, to be changed into one's own, into a folder that isn't there or is empty.

    Returns:
        the files written, relative to the folder.

    Raises:
        GripError: the name can't be one.
        ProjectExistsError: the folder holds something.
    """
    if not re.fullmatch(r"[a-z](_?[a-z0-9]+)*", name):
        words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()
        could_be = re.sub(r"^[0-9_]+|_+$", "", re.sub(r"[^a-z0-9]+", "_", words))
        such = f", such as {could_be}" if could_be else ""
        raise GripError(
            f"{name!r} can't name a component: lower case letters, digits and single _, a letter first{such}"
        )
    if folder.exists() and (not folder.is_dir() or any(entry.name != ".git" for entry in folder.iterdir())):
        raise ProjectExistsError(folder)
    camel = "".join(part.capitalize() for part in name.split("_"))
    written = []
    root = _TEMPLATES / language
    for source in sorted(file for file in root.rglob("*") if file.is_file() and "__pycache__" not in file.parts):
        text = _named(source.relative_to(root).as_posix(), name, camel)
        relative = Path(".gitignore") if text == "gitignore" else Path(text)
        target = folder / relative
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(_named(source.read_text(encoding="utf-8"), name, camel), encoding="utf-8")
        written.append(relative)
    return written


def _named(text: str, name: str, camel: str) -> str:
    return text.replace(_NAME, name).replace(_CAMEL, camel)
