"""A first component file, as a person would write it, from an interface and the few words that it doesn't say."""

from __future__ import annotations

import re
from collections.abc import Collection

from grip_bt.base.errors import GripError
from grip_bt.task.catalog.component_file import ComponentFile
from grip_bt.task.catalog.interface_spec import FieldSpec, InterfaceSpec

from .contract import keeps_contract, suggested_outcomes
from .port_fit import VALUE_OF


class OutcomesNeededError(GripError):
    """An interface doesn't say how its software can end; `suggestion` is what could be given."""

    def __init__(self, interface: InterfaceSpec):
        self.suggestion = suggested_outcomes(interface)
        if keeps_contract(interface):
            what = "its result numbers an outcome, but how many there are, and what they are called, isn't said"
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
    value = VALUE_OF.get(field.type, "")
    return f"list[{value}]" if value and field.array else value


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
