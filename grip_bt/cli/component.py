"""`grip component add|list|test`: external software as nodes."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

NODE_FOLDER = "node"


def add_parser(subparsers: Any) -> None:
    """Add the verb."""
    parser = subparsers.add_parser("component", help="wrap external software: generate its node, list, test")
    actions = parser.add_subparsers(title="actions", metavar="ACTION", required=True)
    add = actions.add_parser("add", help="generate the node of a component into its folder node/")
    add.add_argument("folder", type=Path, nargs="+", help="a component: a folder with component.yaml")
    add.add_argument("--check", action="store_true", help="write nothing; exit 1 when the node isn't up to date")
    add.set_defaults(run=run_add)
    listing = actions.add_parser("list", help="the components of a project")
    listing.add_argument("project", type=Path, nargs="?", default=Path(), help="project folder (default: here)")
    listing.set_defaults(run=run_list)
    test = actions.add_parser("test", help="start a component, call it once, and check its answer")
    test.add_argument("folder", type=Path, help="a component: a folder with component.yaml")
    test.set_defaults(run=run_test)


def run_add(args: argparse.Namespace) -> int:
    """Generate, or check that what was generated is up to date."""
    from grip_bt.codegen import outdated, write_package

    stale = False
    for folder in args.folder:
        files = rendered(folder)
        target = folder / NODE_FOLDER
        if args.check:
            for path in outdated(target, files):
                print(f"{target / path} isn't up to date; run: grip component add {folder}", file=sys.stderr)
                stale = True
        else:
            changed = write_package(target, files)
            print(f"{target}: {', '.join(changed) or 'up to date'}")
    return int(stale)


def run_list(args: argparse.Namespace) -> int:
    """Print each component with its service, outcomes and whether its node is up to date."""
    from grip_bt.app.project import find_project
    from grip_bt.catalog.component_file import load_component
    from grip_bt.codegen import outdated
    from grip_bt.ros.components import find_components

    project = find_project(args.project)
    folder = project.folder / (project.file.components or "components")
    for name, home in find_components(folder).items():
        component = load_component(home)
        stale = outdated(home / NODE_FOLDER, rendered(home))
        state = "node is not up to date" if stale else "node up to date"
        print(f"{name:<24} {component.interface}  {component.server}  {', '.join(component.outcomes)}  ({state})")
    return 0


def run_test(args: argparse.Namespace) -> int:
    """Start the component, call it with an empty request, and tell what it answered and how fast."""
    import time

    from grip_bt.app.project import find_project
    from grip_bt.catalog.component_file import load_component
    from grip_bt.ros.components import start_components

    folder = args.folder.resolve()
    component = load_component(folder)
    stale = run_add(argparse.Namespace(folder=[args.folder], check=True))
    project = find_project(folder).folder
    with start_components(project, [component.name], folder=folder.parent) as components:
        print(f"interfaces: {_seconds(components.build_seconds)}")
        print(f"server: {component.server} after {components.ready_seconds:.2f} s")
        started = time.perf_counter()
        operation = components.client(component.name).call({})
        operation.wait(component.timeouts.call + 1)
        reply = operation.result()
        label = component.outcomes[reply["outcome"]]
        print(f"empty request: {label!r} ({reply['outcome']}) after {(time.perf_counter() - started) * 1e3:.1f} ms")
    return stale


def rendered(folder: Path) -> dict[str, str]:
    """Return the files of a component's node, from its component file and its interface.

    Raises:
        DocumentError, ContractError: see `grip_bt.codegen.render`.
    """
    from grip_bt.catalog.component_file import load_component
    from grip_bt.codegen import render
    from grip_bt.ros.interfaces import read_interface
    from grip_bt.ros.interfaces.source import interface_file

    component = load_component(folder)
    own = interface_file(folder / "interfaces", component.interface)
    return render(component, read_interface(own or component.interface))


def _seconds(seconds: float) -> str:
    return f"built in {seconds:.1f} s" if seconds else "in the cache"
