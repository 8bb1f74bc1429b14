"""Faults that a run injects into its simulated world: when nodes begin, and into the servers of components."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress

from grip_bt.base.errors import DocumentError, GripError, UnknownNameError
from grip_bt.base.yaml.models import Settings, check_model
from grip_bt.base.yaml.tree import parse
from grip_bt.nodes.node import Observer
from grip_bt.runtime import Runner
from grip_bt.runtime.debugger import node_path
from grip_sim.faults import Fault

from ..wiring.parts import Resources


class _Given(Settings):
    faults: dict[str, Fault]


def read_faults(given: Sequence[str]) -> dict[str, Fault]:
    """Return the faults of a command line by name.

    Args:
        given: texts as in a world's file, `NAME: {fault: drop, node: attempt/lift}`.

    Raises:
        DocumentError: one isn't a fault, or two have one name.
    """
    found: dict[str, Fault] = {}
    for text in given:
        read, wrong = check_model(parse(f"faults: {{{text}}}", "--fault"), _Given, "--fault")
        if read is None:
            raise DocumentError(f"{text}: {'; '.join(message for message, _, _ in wrong)}", "--fault")
        if twice := found.keys() & read.faults:
            raise DocumentError(f"two faults are called {min(twice)!r}", "--fault")
        found |= read.faults
    return found


def check_nodes(faults: Mapping[str, Fault], nodes: Collection[str]) -> None:
    """Raise UnknownNameError where a fault waits for a node that the task doesn't have."""
    for name, fault in faults.items():
        if fault.node and node_path(fault.node) not in nodes:
            raise UnknownNameError("node", fault.node, nodes, f"faults/{name}/node")


class _AtNodes(Observer):
    def __init__(self, entered: Callable[[str], None], nodes: Iterable[str]):
        self._entered, self._nodes = entered, {node_path(node): node for node in nodes}

    def entered(self, path: str) -> None:
        if path in self._nodes:
            with suppress(GripError):  # a simulator that is lost is told of by whoever moves it
                self._entered(self._nodes[path])


@contextmanager
def injected(resources: Resources, runner: Runner, tell: Callable[[str, str], None]) -> Iterator[None]:
    """Have the faults of the simulated world happen while the block runs; before the runner begins.

    Args:
        tell: told of each, by `fault` and what happened.
    """
    world = resources.world
    if world is None or not world.spec.faults:
        yield
        return
    faults, servers, hanging = world.spec.faults, resources.servers, set[str]()

    def happened(name: str, words: str, over: bool) -> None:
        fault = faults[name]
        pid = servers.get(fault.of) if fault.fault.startswith("component_") else None
        if pid is not None:
            _signal(pid, fault.fault, over)
            hanging.add(fault.of)
        tell("fault", f"{name}: {words}")

    world.on_fault = happened
    runner.observe(_AtNodes(world.entered, [fault.node for fault in faults.values() if fault.node]))
    try:
        yield
    finally:
        for component in hanging:  # what hangs doesn't end when it is asked to
            _signal(servers[component], "component_hang", over=True)


def _signal(pid: int, kind: str, over: bool) -> None:
    word = signal.SIGCONT if over else signal.SIGKILL if kind == "component_death" else signal.SIGSTOP
    with suppress(ProcessLookupError):
        os.kill(pid, word)
