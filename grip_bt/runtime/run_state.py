"""What a run's nodes and variables are like at one moment: events taken in, one after the other.

Whoever shows a run uses this, over events that were read from the journal: a replay, and a run that is under way.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

from .journal_events import Event

Phase = Literal["running", "ended", "interrupted", "error"]


@dataclass(frozen=True)
class NodeState:
    """One node.

    Attributes:
        phase: running, ended with an outcome, interrupted, or it raised.
        since: when this phase began, on the run's clock [s].
        activations: how often it was entered.
        outcome: of an end.
        code: of a failure.
        message: why it failed, or what it says about its work.
    """

    phase: Phase
    since: float
    activations: int = 0
    outcome: str | None = None
    code: str | None = None
    message: str = ""


@dataclass
class Moment:
    """A run after some of its events.

    Attributes:
        nodes: path -> state, of nodes that were entered.
        variables: name -> the last event that wrote it.
        state: running, paused, stopping; or how the run has ended.
        seq: the last event taken in.
        t: its time on the run's clock [s].
    """

    nodes: dict[str, NodeState] = field(default_factory=dict)
    variables: dict[str, Event] = field(default_factory=dict)
    state: str = "running"
    seq: int = 0
    t: float = 0.0

    def apply(self, event: Event) -> None:
        """Take in the next event; kinds that aren't known change nothing."""
        self.seq, self.t = event.seq, event.t
        before = self.nodes.get(event.path)
        count = before.activations if before is not None else 0
        match event.event:
            case "enter":
                self.nodes[event.path] = NodeState("running", event.t, count + 1)
            case "exit":
                message = str(event.data.get("message", ""))
                self.nodes[event.path] = NodeState("ended", event.t, count, event.outcome, event.code, message)
            case "interrupted":
                self.nodes[event.path] = NodeState("interrupted", event.t, count)
            case "error":
                message = str(event.data.get("message", ""))
                self.nodes[event.path] = NodeState("error", event.t, count, message=message)
            case "message" if before is not None:
                self.nodes[event.path] = replace(before, message=str(event.data.get("text", "")))
            case "write":
                self.variables[str(event.data.get("variable"))] = event
            case "state":
                self.state = str(event.data.get("state"))
            case "run_resumed":
                self.state = "running"
                for path, node in self.nodes.items():
                    if node.phase == "error":  # its process died there; it runs on
                        self.nodes[path] = replace(node, phase="running", message="")
            case "run_ended":
                self.state = str(event.data.get("status"))

    def active(self) -> list[str]:
        """Return the nodes that run, in the order in which they were entered first."""
        return [path for path, node in self.nodes.items() if node.phase == "running"]
