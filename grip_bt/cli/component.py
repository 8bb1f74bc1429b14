"""`grip component`: external software as nodes; `grip interfaces`: building ROS interface packages."""

from __future__ import annotations

import argparse
import re
import shlex
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from grip_bt.app.project.components import Draft, components_folder, from_file, from_graph, label_of, make_component
from grip_bt.app.project.folder import find_project
from grip_bt.app.project.foreign_code import of_component, refuse
from grip_bt.base.errors import GripError, listing, nearest
from grip_bt.base.failures import BadReplyError
from grip_bt.base.types import check_value
from grip_bt.cli.parser import add_actions, add_no_code
from grip_bt.cli.terminal import Bar, progress, tell
from grip_bt.codegen import component_manifest, outdated, render, write_package
from grip_bt.codegen.scaffold import make_repository
from grip_bt.ros.interfaces import build_interfaces, read_interface
from grip_bt.ros.interfaces.definition import fields_within, interface_file
from grip_bt.task.catalog.component_file import FILE_NAME, ComponentFile, load_component
from grip_bt.task.catalog.ros_config import InterfaceSpec

_NODE_FOLDER = "node"
_MOST = 6
"""How many files of a package are listed."""
KINDS = ("srv", "action", "msg")


def add_component(parser: argparse.ArgumentParser) -> None:
    new, add, listed, test = add_actions(
        parser,
        {
            "new": (_run_new, "a working template repository of a component, to be adapted"),
            "add": (_run_add, "make a component, or generate the node of one into its folder node/"),
            "list": (_run_list, "the components of a project"),
            "test": (_run_test, "start a component, call it once, and check its answer"),
        },
    )
    new.add_argument("name", help="of the component: lower case, such as my_grasps")
    new.add_argument("--lang", choices=("python", "cpp"), default="python", help="of its server (default: python)")
    new.add_argument("--folder", type=Path, help="where (default: components/NAME of the project here)")
    what = "a component's folder; or a .srv, .action or .msg file; or a type such as std_srvs/srv/Trigger"
    add.add_argument("what", nargs="*", help=what)
    add.add_argument("--from-graph", metavar="NAME", help="a running service, action or topic")
    ends = "`one,none`: names of 0, 1 ...; `2`; `found: count > 0; none: true`"
    add.add_argument("--outcomes", metavar="O", help=ends)
    add.add_argument("--failure", metavar="LABELS", default="", help="outcomes that mean failure, such as none,timeout")
    add.add_argument("--name", default="", help="the component's name (default: from the server's)")
    add.add_argument("--server", default="", help="the name under which it is served, such as /plan_grasp")
    add.add_argument("--interfaces", type=Path, metavar="FOLDER", help="where the type of --from-graph is defined")
    add.add_argument("--project", type=Path, default=Path(), help="project folder (default: here)")
    add.add_argument("--wait", type=float, default=5.0, metavar="S", help="how long to look at the graph [s]")
    add.add_argument("--check", action="store_true", help="write nothing; exit with 1 if the node isn't up to date")
    listed.add_argument("project", type=Path, nargs="?", default=Path(), help="project folder (default: here)")
    listed.add_argument("--json", action="store_true", help="print one JSON list")
    test.add_argument("folder", type=Path, help="a component: a folder with component.yaml")
    test.add_argument("--json", action="store_true", help="print one JSON object")
    add_no_code(test)


def _run_new(args: argparse.Namespace) -> None:
    folder = args.folder or components_folder(Path()) / args.name
    written = make_repository(folder, args.name, args.lang)
    print(f"{folder}: {', '.join(str(file) for file in written)}")
    generate([folder])
    algorithm = "algorithm.py" if args.lang == "python" else "src/algorithm.cpp"
    print(f"next: grip component test {shlex.quote(str(folder))}; then put your own into {folder / algorithm}")


def _run_add(args: argparse.Namespace) -> int:
    if not args.what and not args.from_graph:
        raise GripError("say what: a folder, an interface file, a type, or --from-graph NAME")
    folders = [folder for what in args.what if (folder := _folder(what, args)) is not None]
    if args.from_graph:
        folders.append(_made(from_graph(args.from_graph, args.wait, args.interfaces), args))
    return check(folders) if args.check else generate(folders)


def _folder(what: str, args: argparse.Namespace) -> Path:
    path = Path(what)
    if path.is_dir():
        _check_component(path)
        return path
    if path.suffix[1:] in KINDS:
        return _made(from_file(path), args)
    if re.fullmatch(r"[a-z][a-z0-9_]*/(\w+/)?[A-Z]\w*", what) or what.count("/") == 2:
        return _made(Draft(read_interface(what)), args)
    home = components_folder(args.project)
    known = [file.parent.name for file in sorted(home.glob(f"*/{FILE_NAME}"))]
    raise GripError(
        f"{path}: there is no such folder{nearest(path.name, known)} (available in {home}: {listing(known)}); give a "
        "component's folder, an interface file, or a type such as std_srvs/srv/Trigger"
    )


def _check_component(folder: Path) -> None:
    """Refuse a folder without a component, or with one under another name than that by which a run looks for it."""
    if not (folder / FILE_NAME).exists():
        files = sorted(f.relative_to(folder).as_posix() for kind in KINDS for f in folder.glob(f"{kind}/*.{kind}"))
        shown = f"{', '.join(files[:_MOST])}{', ...' if len(files) > _MOST else ''}"
        package = f"it is an interface package: give one of its files ({shown})" if files else ""
        advice = package or "`grip component new NAME` makes a component"
        raise GripError(f"{folder}: there is no {FILE_NAME} in it; {advice}")
    name, home = load_component(folder).name, folder.resolve()
    if home.name != name and home.parent == components_folder(home).resolve():
        raise GripError(
            f"{folder}: the component is called {name!r}, and a run looks for it in {home.parent / name}: rename the "
            f"folder, or write `name: {home.name}` in {FILE_NAME}"
        )


def _made(draft: Draft, args: argparse.Namespace) -> Path:
    draft = replace(draft, name=args.name, server=args.server or draft.server)
    failures = [label for label in args.failure.split(",") if label]
    folder = make_component(draft, components_folder(args.project), args.outcomes, failures)
    component = load_component(folder)
    print(f"{folder / 'component.yaml'}: {draft.interface.type_name}, served as {component.server}")
    if len(component.outcomes) > 1 and not component.meaning:
        said = f"all of {listing(component.outcomes)} mean success; of one that doesn't: `meaning: {{LABEL: failure}}`"
        print(f"{said} in component.yaml, or --failure LABEL", file=sys.stderr)
    return folder


def generate(folders: Sequence[Path]) -> int:
    for folder in folders:
        changed = write_package(folder / _NODE_FOLDER, rendered(folder))
        print(f"{folder / _NODE_FOLDER}: {', '.join(changed) or 'up to date'}")
    return 0


def check(folders: Sequence[Path]) -> int:
    """Tell which nodes aren't up to date; 1 when there are some."""
    stale = [(folder, path) for folder in folders for path in outdated(folder / _NODE_FOLDER, rendered(folder))]
    for folder, path in stale:
        print(f"{folder / _NODE_FOLDER / path} isn't up to date; run: grip component add {folder}", file=sys.stderr)
    return int(bool(stale))


def _run_list(args: argparse.Namespace) -> int:
    """Print each component with its service, outcomes and whether its node is up to date; 1 when one is broken."""
    project = find_project(args.project)
    found = project.component_folders()
    if not found:
        where = project.folder / (project.file.components or "components")
        print(f"no components in {where}; `grip component new NAME` makes one", file=sys.stderr)
    rows, broken = list[dict[str, Any]](), False
    for folder, home in found.items():
        try:
            component = load_component(home)
            stale = outdated(home / _NODE_FOLDER, rendered(home))
        except GripError as error:
            broken = True
            print(f"{folder:<24} can't be read: {error}", file=sys.stderr)
            continue
        row = {key: getattr(component, key) for key in ("name", "interface", "server", "outcomes")}
        rows.append(row | {"outcomes": list(component.outcomes), "up_to_date": not stale})
    line = "{name:<24} {interface}  {server}  {0}  (node {1}up to date)"
    lines = (line.format(", ".join(r["outcomes"]), "" if r["up_to_date"] else "is not ", **r) for r in rows)
    tell(args.json, rows, lines)
    return int(broken)


def _run_test(args: argparse.Namespace) -> int:
    """Start the component, call it once (an action: one goal) with nothing in it, and tell the answer and its time."""
    from grip_bt.ros.components import start_components

    folder = args.folder.resolve()
    component = load_component(folder)
    refuse(of_component(folder))
    stale = check([args.folder])
    project = find_project(folder).folder

    with start_components(project, [component.name], folder=folder.parent, progress=progress) as components:
        built, ready, started = components.build_seconds, components.ready_seconds, time.perf_counter()
        operation = components.client(component.name).call({})
        operation.wait(component.timeouts.call + component.timeouts.ready + 1)
        reply, took = operation.result(), (time.perf_counter() - started) * 1e3
    for name, port in component_manifest(component, _interface(folder, component)).outputs.items():
        if name in reply and (reason := check_value(port.type, reply[name])):
            raise BadReplyError(f"the answer's port {name!r} {reason}; say its type under `ports:`", field=name)
    label = label_of(component, reply)
    number = "" if component.rules else f" ({reply['outcome']})"
    lines = (
        f"interfaces: {f'built in {built:.1f} s' if built else 'in the cache'}",
        f"server: {component.server} after {ready:.2f} s",
        f"empty request: {f'{label!r}{number}' if label else 'no rule holds'} after {took:.1f} ms",
    )
    seconds = {"built": built, "ready": ready, "answered": took / 1e3}
    facts = {"name": component.name, "server": component.server, "outcome": label, "seconds": seconds}
    tell(args.json, facts | {"up_to_date": not stale}, lines)
    return stale


def rendered(folder: Path) -> dict[str, str]:
    """Return the files of a component's node, from its component file and its interface; see `codegen.render`."""
    component = load_component(folder)
    return render(component, _interface(folder, component), partial(fields_within, folder / "interfaces"))


def _interface(folder: Path, component: ComponentFile) -> InterfaceSpec:
    return read_interface(interface_file(folder / "interfaces", component.interface) or component.interface)


def add_interfaces(parser: argparse.ArgumentParser) -> None:
    what = {"build": (_run_interfaces, "build the .msg, .srv and .action packages in a folder, once per content")}
    (build,) = add_actions(parser, what)
    build.add_argument("folder", type=Path, help="an interface package, or a folder with some")
    build.add_argument("--json", action="store_true", help="print one JSON list")


def _run_interfaces(args: argparse.Namespace) -> None:
    with Bar("packages") as bar:
        built = build_interfaces(args.folder, progress=bar)
    rows = [{"package": b.package, "prefix": str(b.prefix), "seconds": round(b.seconds, 2)} for b in built]
    lines = (f"{b.package:<28} {'cached' if b.cached else f'{b.seconds:5.1f} s'}  {b.prefix}" for b in built)
    tell(args.json, rows, lines)
