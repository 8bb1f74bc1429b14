"""A component's node package as text. Pure: equal components and interfaces give equal bytes; `write` does the rest."""

from __future__ import annotations

from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined

from grip_bt.base.expression import parse_expression
from grip_bt.base.python_literals import py
from grip_bt.task.catalog.component_file import ComponentFile
from grip_bt.task.catalog.interface_spec import InterfaceSpec
from grip_bt.task.catalog.manifest_text import manifest_text

from .contract import check_contract
from .face import class_name, face
from .port_fit import FieldsOf
from .trial import default_outcome

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
    manifest = face(component, interface)
    meaning = {
        "words": _words(component),
        "tried": default_outcome(component, interface) if component.rules else None,
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
    files |= {path: _environment().get_template(template).render(meaning) for path, template in templates.items()}
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
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("grip_bt.codegen"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # what is made is Python and Markdown; values enter Python through `py` alone
    )
    environment.filters["py"] = py
    return environment
