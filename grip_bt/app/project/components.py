"""A component's folder made from what there is: an interface file, the name of a type, or a server that runs."""

from __future__ import annotations

import re
import sys
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import DocumentError, GripError
from grip_bt.base.evaluation import condition_of
from grip_bt.base.expression import parse_expression
from grip_bt.base.files import copy_folder
from grip_bt.base.yaml.models import check_model, diagnostic_of, document_error
from grip_bt.base.yaml.tree import YamlMapping, parse
from grip_bt.codegen.contract import check_contract
from grip_bt.codegen.scaffold import OutcomesNeededError, component_text, parse_outcomes, suggested_name
from grip_bt.ros.interfaces import read_interface, read_package
from grip_bt.ros.interfaces.definition import fields_within, interface_file
from grip_bt.ros.interfaces.packages import KINDS
from grip_bt.task.catalog.component_file import FILE_NAME, ComponentFile
from grip_bt.task.catalog.ros_config import InterfaceSpec


@dataclass(frozen=True)
class Draft:
    """What is known of a component to be.

    Attributes:
        server: the name under which it is served; empty for one made from the interface's.
        name: the component's; empty for one made from the server's.
        package: folder of the interface package, to be copied; None for an installed one.
        script: what serves it in its own repository, where that was found.
    """

    interface: InterfaceSpec
    server: str = ""
    name: str = ""
    package: Path | None = None
    script: Path | None = None


def from_file(path: Path) -> Draft:
    """Take a .srv, .action or .msg file of an interface package; DocumentError where it isn't one or lies in none."""
    if not path.is_file():
        raise DocumentError("there is no such file", str(path))
    package = path.resolve().parent.parent
    if not (package / "package.xml").is_file():
        where = f"<package>/{path.suffix[1:]}/{path.name}, beside a package.xml"
        reason = f"an interface belongs to a package, whose name is part of its type: put the file into {where}"
        raise DocumentError(reason, str(path))
    return Draft(read_interface(path), package=package)


def served_in(draft: Draft) -> Draft:
    """Find the Python script of an interface's own repository that serves it, and under which name; read, never run."""
    home = draft.package
    if home is None:
        return draft
    root = next((folder for folder in (home, *home.parents) if (folder / ".git").exists()), home)
    kind = r"create_service\(\s*" if draft.interface.kind == "srv" else r"ActionServer\(\s*[\w.]+\s*,\s*"
    served = re.compile(rf"""{kind}(?:[\w.]+\.)?{draft.interface.name}\s*,\s*['"]([\w/~]+)['"]""")
    for file in sorted(root.rglob("*.py")):
        if found := served.search(file.read_text("utf-8", errors="replace")):
            return replace(draft, server=f"/{found[1].lstrip('/~')}", script=file)
    return draft


def from_graph(name: str, within: float, interfaces: Path | None = None) -> Draft:
    """Take what runs: its type is asked of the running graph `within` a time [s].

    Args:
        interfaces: folder with the package that defines the type, for one that isn't installed.

    Raises:
        UnknownNameError, GripError: nothing of that name runs; its type isn't known here.
    """
    from grip_bt.ros.client.graph import find_served

    served = find_served(name, within)
    if interfaces is not None and (file := interface_file(interfaces, served.type)) is not None:
        return Draft(read_interface(file), served.name, package=file.parent.parent)
    try:
        return Draft(read_interface(served.type), served.name)
    except DocumentError as error:
        advice = "give the folder of its interface package: --interfaces FOLDER"
        raise GripError(f"{served.name} is of type {served.type}, but {error.message}; {advice}") from None


def make_component(draft: Draft, folder: Path, outcomes: str | None, failures: Collection[str] = ()) -> Path:
    """Write the folder of a component with its component file; return it.

    Args:
        outcomes: as `--outcomes` takes them; None asks the user, on a terminal.

    Raises:
        OutcomesNeededError: nobody said how it can end.
        GripError: it is there already, or (ContractError) the interface and the outcomes don't fit; nothing is written.
    """
    server = draft.server or "/" + suggested_name(draft.interface)
    name = draft.name or server.strip("/").replace("/", "_").lower()
    home = folder / name
    if (home / FILE_NAME).exists():
        raise GripError(f"{home / FILE_NAME} already exists; edit it and run: grip component add {home}")
    if outcomes is None and draft.interface.kind != "msg":
        needed = OutcomesNeededError(draft.interface)
        if not sys.stdin.isatty():
            raise needed
        outcomes = input(f"{needed}\noutcomes [{needed.suggestion}]: ").strip() or needed.suggestion
    chosen = {"received": "true"} if outcomes is None else parse_outcomes(outcomes)
    try:
        text = component_text(draft.interface, name, server, chosen, failures)
        component, faults = check_model(parse(text), ComponentFile)
        if component is None:
            raise document_error(faults, FILE_NAME)
        check_contract(component, draft.interface, partial(fields_within, draft.package and draft.package.parent))
    except ValidationError as error:
        raise GripError(diagnostic_of(YamlMapping({}, 1, 1), error.errors()[0])[0]) from None
    home.mkdir(parents=True, exist_ok=True)
    for package in _with_needed(draft.package):
        if not (home / "interfaces" / package.name).exists():
            copy_folder(package, home / "interfaces" / package.name, _not_of_interfaces)
    (home / FILE_NAME).write_text(text, encoding="utf-8")
    return home


def _not_of_interfaces(folder: str, names: list[str]) -> set[str]:
    """Return what isn't copied of a package: all but what its interfaces are built from."""
    inside = Path(folder).name in KINDS
    return {name for name in names if not (inside or name in ("package.xml", "CMakeLists.txt", *KINDS))}


def _with_needed(folder: Path | None) -> list[Path]:
    """Return a package's folder, and those beside it that it needs, directly or not."""
    found: dict[str, Path] = {}
    todo = [] if folder is None else [folder]
    while todo:
        package = read_package(todo.pop())
        found[package.name] = package.folder
        beside = (package.folder.parent / name for name in package.depends - found.keys())
        todo += [home for home in beside if (home / "package.xml").is_file()]
    return list(found.values())


def components_folder(start: Path) -> Path:
    """Return the folder of the components of the project around `start`."""
    project = find_project(start)
    return project.folder / (project.file.components or "components")


def label_of(component: ComponentFile, reply: Mapping[str, Any]) -> str:
    """Return the outcome of an answer: by its number, or by the outcomes' rules; empty where no rule holds."""
    if not component.rules:
        return str(component.outcomes[reply["outcome"]])
    for label, text in component.rules.items():
        rule = parse_expression(text)
        if condition_of(rule, {name: partial(reply.__getitem__, name) for name in rule.names})():
            return label
    return ""
