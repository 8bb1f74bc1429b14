"""A component's node package as text: its manifest (a port for each field, a label for each outcome), class and test.

Pure: equal components and interfaces give equal bytes; `write` does the rest.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, partial
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined, Template

from grip_bt.base.errors import EvaluationError, GripError
from grip_bt.base.evaluation import condition_of
from grip_bt.base.expression import parse_expression
from grip_bt.base.files import replace_text, text_in
from grip_bt.base.frozen import FrozenDict
from grip_bt.base.python_literals import py
from grip_bt.codegen.contract import INPUT, FieldsOf, check_contract, input_ports, output_ports, port_type, received
from grip_bt.task.catalog.component_file import FEEDBACK, ComponentFile
from grip_bt.task.catalog.manifest import InputPort, Manifest, OutputPort, manifest_text
from grip_bt.task.catalog.ros_config import INTEGER_TYPES, FieldSpec, InterfaceSpec
from grip_bt.task.model import Meaning

MARK = "Generated from component.yaml by `grip component add`"
"""In the first lines of every generated file; a file without it is somebody's own and never overwritten."""
_HEADER = f"# {MARK}; edits here are lost when it runs again.\n"


def render(
    component: ComponentFile, interface: InterfaceSpec, fields_of: FieldsOf = lambda message: None
) -> dict[str, str]:
    """Return the files of a component's node package, by path in the package; `fields_of` as for `check_contract`.

    Raises:
        ContractError: the interface doesn't keep the component contract.
    """
    check_contract(component, interface, fields_of)
    manifest = component_manifest(component, interface)
    meaning = {
        "words": _words(component),
        "tried": default_case(component, interface) if component.rules else None,
        "rule_names": sorted({n for rule in component.rules.values() for n in parse_expression(rule).names}),
        "component": component,
        "interface": interface,
        "manifest": manifest,
        "class_name": class_name(component),
        "mark": MARK,
        "header": _HEADER,
    }
    templates = {
        "leaf.py": "leaf.py.j2",
        f"test_{component.name}.py": "test_leaf.py.j2",
        "README.md": "README.md.j2",
    }
    files = {"manifest.yaml": manifest_text(manifest, _HEADER)}
    files |= {path: template(__package__, name).render(meaning) for path, name in templates.items()}
    return files


def _words(component: ComponentFile) -> dict[str, str]:
    """Return the phrases that differ by kind."""
    by = "whose rule holds" if component.rules else "that the response numbers"
    if component.kind == "action":
        by = by.replace("response", "result")
        does = f"Sends the inputs as the goal and ends with the outcome {by}."
        return {"does": does, "calls": "Sends a goal to the action", "answer": "the result"}
    if component.kind == "srv":
        does = f"Sends the inputs as the request and ends with the outcome {by}."
        return {"does": does, "calls": "Calls the service", "answer": "an answer"}
    if component.use == "publish":
        return {"does": "Publishes the inputs as a message.", "calls": "Publishes to", "answer": "a subscriber"}
    return {"does": "Waits for the next message.", "calls": "Waits for a message on", "answer": "it"}


@cache
def template(package: str, name: str) -> Template:
    """Return a template of a package."""
    environment = Environment(
        loader=PackageLoader(package),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # what is made is Python and Markdown; values enter Python through `py` and `literal` alone
    )
    environment.filters["py"] = py
    return environment.get_template(name)


CODES: dict[str, tuple[str, ...]] = {
    "srv": ("server_lost", "timed_out", "bad_reply"),
    "action": ("server_lost", "timed_out", "bad_reply", "rejected", "aborted", "canceled"),
    "msg": ("timed_out", "bad_reply"),
}
"""Why a node of each kind may fail."""


def class_name(component: ComponentFile) -> str:
    """Return the name of a component's leaf, such as `AntipodalGrasps`."""
    return "".join(part[:1].upper() + part[1:] for part in component.name.split("_"))


def component_manifest(component: ComponentFile, interface: InterfaceSpec) -> Manifest:
    """Return the manifest of a component's node."""
    outcomes: dict[str, Meaning] = {**component.meanings(), "failure": "failure"}
    fields = {f.name: f for f in interface.request}
    inputs = {
        port: InputPort(
            type=_type(component, fields, port, at),
            doc=_doc(component, fields, port, at),
            required=port == INPUT and not component.rules,
        )
        for port, at in input_ports(component, interface).items()
    }
    answer = received(component, interface)
    outputs = {
        port: OutputPort(type=_type(component, answer, port, at), doc=_doc(component, answer, port, at))
        for port, at in output_ports(component, interface).items()
    }
    if component.kind == "action":
        outputs[FEEDBACK] = _feedback(component, interface, tuple(outcomes))
    return Manifest(
        id=f"component/{component.name}",
        doc=component.doc or interface.doc or f"{_words(component)['calls']} {component.server}.",
        implementation=f"leaf.py:{class_name(component)}",
        inputs=FrozenDict(inputs),
        outputs=FrozenDict(outputs),
        outcomes=FrozenDict(outcomes),
        codes=CODES[component.kind],
        moves=None if component.moves else False,
    )


def _feedback(component: ComponentFile, interface: InterfaceSpec, outcomes: tuple[str, ...]) -> OutputPort:
    """Return the port of the last feedback; it is written however the goal ends, None where there was no feedback."""
    type_ = component.port_type(FEEDBACK, f"{interface.type_name}_Feedback")
    said = component.ports[FEEDBACK].doc if FEEDBACK in component.ports else ""
    optional = type_ if "| None" in type_ or type_ == "Any" else f"{type_} | None"
    return OutputPort(type=optional, doc=said or "the last feedback", on=outcomes)


def _type(component: ComponentFile, fields: Mapping[str, FieldSpec], port: str, at: str) -> str:
    return component.port_type(port, port_type(fields[at]) if at in fields else "Any")


def _doc(component: ComponentFile, fields: Mapping[str, FieldSpec], port: str, at: str) -> str:
    said = component.ports[port].doc if port in component.ports else ""
    return said or (fields[at].doc if at in fields else "")


_DEFAULTS: dict[str, Any] = {
    **dict.fromkeys(INTEGER_TYPES, 0),
    **{"bool": False, "string": "", "wstring": "", "float32": 0.0, "float64": 0.0},
}


def default_reply(component: ComponentFile, interface: InterfaceSpec) -> dict[str, object]:
    """Return the outputs of an empty answer, those that are numbers, texts, truth values or lists."""
    fields = received(component, interface)
    ports = output_ports(component, interface)
    return {
        port: [] if fields[at].array else _DEFAULTS[fields[at].type]
        for port, at in ports.items()
        if at in fields and (fields[at].array or fields[at].type in _DEFAULTS)
    }


def default_case(component: ComponentFile, interface: InterfaceSpec) -> tuple[dict[str, object], str | None] | None:
    """Return an empty answer and the outcome that the rules give it, None for none of them.

    Returns:
        None when the rules read fields whose empty values aren't plain literals.
    """
    reply = default_reply(component, interface)
    for label, text in component.rules.items():
        rule = parse_expression(text)
        if any(name not in reply for name in rule.names):
            return None
        try:
            if condition_of(rule, {name: partial(reply.__getitem__, name) for name in rule.names})():
                return reply, label
        except EvaluationError:
            return None
    return reply, None


class NotOursError(GripError):
    """A file that would be overwritten wasn't generated."""

    def __init__(self, path: Path):
        self.path = path
        super().__init__(f"{path} was not generated and would be overwritten; move it, or choose another folder")


def outdated(folder: Path, files: Mapping[str, str]) -> list[str]:
    """Return the paths of files that are missing in `folder`, differ, or were generated once and aren't any more."""
    wrong = [path for path, text in files.items() if text_in(folder / path) != text]
    return sorted([*wrong, *(p.name for p in _left_over(folder, files))])


def write_package(folder: Path, files: Mapping[str, str]) -> list[str]:
    """Make `folder` hold `files`; return the paths that were written or removed.

    Raises:
        NotOursError: a file is in the way that wasn't generated; nothing was written.
    """
    changed = outdated(folder, files)
    for path in files:
        present = text_in(folder / path)
        if present is not None and MARK not in present:
            raise NotOursError(folder / path)
    for path in changed:
        if path in files:
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            replace_text(folder / path, files[path])
        else:
            (folder / path).unlink()
    return changed


def _left_over(folder: Path, files: Mapping[str, str]) -> list[Path]:
    if not folder.is_dir():
        return []
    others = (p for p in sorted(folder.iterdir()) if p.is_file() and p.name not in files)
    return [p for p in others if MARK in (text_in(p) or "")[:200]]
