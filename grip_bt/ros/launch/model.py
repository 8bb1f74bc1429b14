"""What a launch file comes to: processes and arguments, and what is in force where they are read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path


@dataclass(frozen=True)
class LaunchedProcess:
    """One process that a launch file asks for.

    Attributes:
        name: of the node or the executable, made unique.
        command: program and arguments.
        env: environment variables beside the inherited ones.
        unset: inherited variables that are taken away.
        folder: working directory, or None for the present one.
        respawn: whether it is started again when it ends.
        respawn_delay: how long to wait before [s].
        required: whether everything ends when it ends (`on_exit="shutdown"`).
        respawns: how often it is started again at most; None for no end.
        after: how long after the beginning it is started [s], by a `timer`.
        place: where it is written, for messages.
    """

    name: str
    command: tuple[str, ...]
    env: Mapping[str, str] = field(default_factory=dict)
    unset: frozenset[str] = frozenset()
    folder: Path | None = None
    respawn: bool = False
    respawn_delay: float = 0.0
    required: bool = False
    place: str = ""
    respawns: int | None = None
    after: float = 0.0


@dataclass(frozen=True)
class LaunchEvent:
    """What a launch file does beside starting processes.

    Attributes:
        text: what is said.
        after: how long after the beginning [s].
        ends: whether everything ends then (`shutdown`).
    """

    text: str
    after: float = 0.0
    ends: bool = False


@dataclass(frozen=True)
class Argument:
    """An argument that a launch file declares."""

    name: str
    default: str | None
    doc: str
    choices: tuple[str, ...] = ()


@dataclass
class Launch:
    """What a launch file asks for."""

    processes: list[LaunchedProcess] = field(default_factory=list)
    arguments: list[Argument] = field(default_factory=list)
    events: list[LaunchEvent] = field(default_factory=list)


@dataclass
class Scope:
    """What a group has of its own; children change a copy, elements of one group share it.

    Attributes:
        variables: what `arg` and `let` have set.
        env: environment variables that were set.
        unset: inherited ones that were taken away.
        namespace: of nodes; empty for none.
        remaps: (from, to) of every node.
        parameters: arguments of every node.
        after: how long after the beginning it all happens [s].
    """

    variables: dict[str, str]
    env: dict[str, str]
    unset: frozenset[str] = frozenset()
    namespace: str = ""
    remaps: tuple[tuple[str, str], ...] = ()
    parameters: tuple[str, ...] = ()
    after: float = 0.0

    def copy(self) -> Scope:
        """Return one that can be changed without changing this."""
        return replace(self, variables=dict(self.variables), env=dict(self.env))


def joined(outer: str, inner: str) -> str:
    """Return a name space within another; one that begins with a slash stands alone."""
    if inner.startswith("/"):
        return inner.rstrip("/")
    return f"{outer}/{inner.rstrip('/')}" if inner else outer
