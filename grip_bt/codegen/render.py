"""A component's node package as text. Pure: equal components and interfaces give equal bytes; `write` does the rest."""

from __future__ import annotations

from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined

from grip_bt.catalog.component_file import ComponentFile
from grip_bt.catalog.interface_spec import InterfaceSpec

from .contract import check_contract
from .face import class_name, face
from .manifest_text import manifest_text
from .quoting import py

MARK = "Generated from component.yaml by `grip component add`"
"""In the first lines of every generated file; a file without it is somebody's own and never overwritten."""
_HEADER = f"# {MARK}; edits here are lost when it runs again.\n"


def render(component: ComponentFile, interface: InterfaceSpec) -> dict[str, str]:
    """Return the files of a component's node package, by path in the package.

    Raises:
        ContractError: the interface doesn't keep the component contract.
    """
    check_contract(component, interface)
    manifest = face(component, interface)
    meaning = {
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
