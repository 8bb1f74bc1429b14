"""The components of a project, from folder to port: interfaces built, processes started, servers found."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from grip_bt.base.errors import DocumentError, UnknownNameError
from grip_bt.base.failures import ServerLostError
from grip_bt.base.files import Closing
from grip_bt.base.ports import Component
from grip_bt.ros.command import advice, start_process
from grip_bt.ros.interfaces.packages import activate
from grip_bt.task.catalog.component_file import FILE_NAME, ComponentFile, load_component

from .client.action import ActionClient
from .client.bus import Bus
from .client.graph import LOOKING
from .client.service import ServiceClient
from .component import Client, RosComponent
from .frames import FrameTree
from .interfaces import Built, build_interfaces
from .process import Process, stop_all
from .watchdog import READY

INTERFACES = "interfaces"
"""Sub-folder of a component with its interface packages."""


class Components(Closing):
    """Components that answer.

    Attributes:
        build_seconds: how long the interfaces took to build; 0 when all were in the cache.
        ready_seconds: how long it took from the start of the processes until all servers were there.
    """

    def __init__(self, bus: Bus, build_seconds: float):
        self.bus, self.build_seconds, self.ready_seconds = bus, build_seconds, 0.0
        self._components: dict[str, RosComponent] = {}
        self._processes: dict[str, Process | None] = {}

    def client(self, name: str) -> Component:
        """Return a component; an empty name means the only one. Raises UnknownNameError: there is none of that name."""
        if not name and len(self._components) == 1:
            return next(iter(self._components.values()))
        if name not in self._components:
            raise UnknownNameError("component", name, self._components)
        return self._components[name]

    def process(self, name: str) -> Process | None:
        """Return a component's process; None when it wasn't started by us."""
        return self._processes[name]

    def add(self, component: RosComponent, process: Process | None) -> None:
        """Add a component; the end of its process ends its calls."""
        file, client = component.file, component.client
        self._components[file.name], self._processes[file.name] = component, process
        if process is not None and isinstance(client, (ServiceClient, ActionClient)):
            client.server_started()
            process.when_ended(lambda: client.server_ended(process.describe_end()))
            process.when_broken(lambda: client.server_ended(process.describe_end(), again=True).wait(LOOKING))

    @property
    def settled(self) -> bool:
        """Whether all processes live, and no server can be at work for a call or a goal any more."""
        clients = [component.client for component in self._components.values()]
        calls = [client for client in clients if isinstance(client, (ServiceClient, ActionClient))]
        alive = all(process is None or process.alive for process in self._processes.values())
        return alive and all(client.settled for client in calls)

    def wait_ready(self) -> None:
        """Wait until every server is there.

        Raises:
            ServerLostError: one isn't within its time, or its process ended; with the end of its log.
        """
        started = time.monotonic()
        waits = [
            (component.file, component.client.wait_ready(component.file.timeouts.ready))
            for component in self._components.values()
            if isinstance(component.client, (ServiceClient, ActionClient))  # of a topic, the node itself waits
        ]
        for file, operation in waits:
            operation.wait(file.timeouts.ready + 5.0)
            try:
                operation.result()
            except ServerLostError as error:
                process = self._processes[file.name]
                alive = process is not None and process.alive
                tail = process.log_tail() if process is not None else ""
                todo = advice(file, error, alive, tail)
                said = f"; its log ({process.log}) ends with:\n{tail}" if process and alive and tail else ""
                raise type(error)(f"component {file.name}: {error.message}{todo}{said}", **error.data) from None
        self.ready_seconds = time.monotonic() - started

    def close(self) -> None:
        """End all calls and all processes that were started, together; then leave ROS."""
        self.bus.close()
        stop_all([process for process in self._processes.values() if process is not None])


def find_components(folder: Path, wanted: Iterable[str]) -> dict[str, Path]:
    """Return the folder of each component below `folder`, by name; a broken one that isn't wanted is left out.

    Raises:
        DocumentError: two have one name, or a component file is wrong, which may be that of one that is wanted.
    """
    found: dict[str, Path] = {}
    broken = None
    for file in sorted(folder.glob(f"*/{FILE_NAME}")):
        try:
            name = load_component(file).name
        except DocumentError as error:
            broken = broken or error
            continue
        if name in found:
            raise DocumentError(f"the component {name!r} is also in {found[name]}", str(file))
        found[name] = file.parent
    if broken is not None and set(wanted) - found.keys():
        raise broken
    return found


def start_components(
    project_folder: Path | str,
    names: Iterable[str],
    domain_id: int | None = None,
    folder: Path | str = "components",
    frames: FrameTree | None = None,
    progress: Callable[[str, str], None] = lambda part, detail: None,
) -> Components:
    """Start the named components of a project and wait until their servers answer.

    Interfaces are built into the user's cache unless they are there; what a component prints goes to
    `<project>/.grip/logs/<name>.log`. A component without `start` is expected to be running.

    Args:
        domain_id: the DDS domain of us and of what we start; ROS_DOMAIN_ID, else 0, by default.
        folder: where the components are, in the project or anywhere.
        frames: where frames are, for ports that are given in one.
        progress: told of each interface package that has to be built, before that.

    Raises:
        UnknownNameError: a component isn't there.
        DocumentError, MissingPartError, InterfaceBuildError: its files are wrong, or its interfaces can't be built, or
            two components bring different packages of one name.
        ServerLostError: a server didn't come; it says why, with the end of its log.
    """
    project = Path(project_folder).resolve()
    wanted = list(dict.fromkeys(names))
    folders = find_components(project / folder, wanted)
    for name in wanted:
        if name not in folders:
            raise UnknownNameError("component", name, folders, str(project / folder))
    files = {name: load_component(folders[name]) for name in wanted}
    started = time.monotonic()
    bring = {name: folder for name in wanted if (folder := folders[name] / INTERFACES).is_dir()}
    words = "{} is built now, once for all runs; this takes some seconds"
    begun = lambda package: progress("interfaces", words.format(package))  # noqa: E731
    built = {name: build_interfaces(folder, begun=begun) for name, folder in bring.items()}
    _check_one_definition(built, folders)
    overlays = {name: [b.prefix for b in built.get(name, ())] for name in wanted}
    fresh = any(not b.cached for packages in built.values() for b in packages)
    seconds = time.monotonic() - started if fresh else 0.0
    for prefix in dict.fromkeys(p for prefixes in overlays.values() for p in prefixes):
        activate(prefix)
    bus = Bus(domain_id=domain_id, watched=True)
    components = Components(bus, seconds)
    try:
        for name, file in files.items():
            log = project / ".grip" / "logs" / f"{name}.log"
            process = start_process(name, file.start, folders[name], log, domain_id, overlays[name])
            if file.qos is not None:
                bus.qos[file.server] = file.qos
            components.add(RosComponent(file, _client(bus, file), frames), process)
        actions = [file.server for file in files.values() if file.kind == "action" and file.moves]
        watchdog = bus.watchdog if actions else None  # which sees to what may move when this process has died
        if watchdog is not None:
            for action in actions:
                watchdog.expect_server(action)
        components.wait_ready()
        if watchdog is not None:
            watchdog.wait_ready(READY)
    except BaseException:
        components.close()
        raise
    return components


def _check_one_definition(built: Mapping[str, Sequence[Built]], folders: Mapping[str, Path]) -> None:
    """Check that components which bring a package of one name bring the same: one process can't hold two of them.

    Raises:
        DocumentError: two differ.
    """
    first: dict[str, tuple[str, Path]] = {}
    for name, packages in built.items():
        for package in packages:
            other, prefix = first.setdefault(package.package, (name, package.prefix))
            if prefix != package.prefix:
                where = str(folders[name] / INTERFACES)
                raise DocumentError(
                    f"the package {package.package!r}, or one that it needs, differs from that of the component "
                    f"{other!r} ({folders[other] / INTERFACES}); a run can load only one version: make them identical",
                    where,
                )


def _client(bus: Bus, file: ComponentFile) -> Client:
    if file.kind == "action":
        return bus.action(file.interface, file.server)
    if file.kind == "srv":
        return bus.service(file.interface, file.server)
    if file.use == "publish":
        return bus.writer(file.interface, file.server)
    reader = bus.reader(file.interface, file.server)
    reader.listen()
    return reader
