"""Where a run is to hold: before or after a node, on an outcome, on a condition."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

from grip_bt.base.errors import GripError, UnknownNameError
from grip_bt.base.values import Failure
from grip_bt.compilers import CompiledMachine, CompiledTree
from grip_bt.compilers.binding import parts_of, probe
from grip_bt.nodes.node import Observer
from grip_bt.runtime.pacing import Pacing

When = Literal["before", "after"]


@dataclass(frozen=True)
class Breakpoint:
    """One place.

    Attributes:
        when: before an activation begins, or after it has ended.
        once: it clears itself when the run has come there.
    """

    id: int
    node: str
    when: When
    outcome: str | None = None
    code: str | None = None
    condition: str = ""
    holds: Callable[[], bool] | None = None
    once: bool = False

    def facts(self) -> dict[str, object]:
        outcome = self.outcome if self.code is None else f"{self.outcome}.{self.code}"
        return {"id": self.id, "node": self.node, "when": self.when, "outcome": outcome, "if": self.condition or None}


def node_path(text: str) -> str:
    """Return a path as the document spells it: `/a/b` is `a/b`, and `/` is the root."""
    return text.strip().strip("/") or "/"


def make_breakpoint(
    compiled: CompiledTree | CompiledMachine,
    id: int,
    node: str,
    when: str = "",
    outcome: str | None = None,
    condition: str = "",
    once: bool = False,
) -> Breakpoint:
    """Check what a user asked for against the task; `outcome` may be `outcome.code`.

    By default it is after where an outcome is given, else before.

    Raises:
        UnknownNameError: there is no such node, outcome, variable or moment.
        ExpressionError: the condition can't be read.
    """
    parts, path = parts_of(compiled), node_path(node)
    if path not in parts:
        raise UnknownNameError("node", path, parts)
    moment = when or ("after" if outcome else "before")
    if moment not in get_args(When) or (outcome and moment == "before"):
        allowed = ["after"] if outcome else get_args(When)
        raise UnknownNameError("moment", moment, allowed, "a breakpoint" + (" on an outcome" if outcome else ""))
    name, _, code = (outcome or "").partition(".")
    if name and name not in parts[path].meaning:
        raise UnknownNameError("outcome", name, parts[path].meaning, path)
    holds = probe(compiled, parts[path], condition) if condition else None
    return Breakpoint(
        id, path, "before" if moment == "before" else "after", name or None, code or None, condition, holds, once
    )


Why = Literal["breakpoint", "step", "run_to"]
STEPS = ("tick", "in", "over", "out")


@dataclass(frozen=True)
class Held:
    """Where a run holds in the middle of a tick.

    Attributes:
        when: before its activation begins, or after it has ended.
        message: of its failure; or why the breakpoint's condition couldn't be computed.
    """

    path: str
    when: When
    why: Why
    breakpoint: int | None = None
    outcome: str | None = None
    code: str | None = None
    message: str = ""


class Debugger(Observer):
    """The observer that holds; it is one only while there is something to hold for, which it tells `needed`."""

    def __init__(self, compiled: CompiledTree | CompiledMachine, pacing: Pacing, needed: Callable[[bool], None]):
        self._compiled, self._pacing, self._needed = compiled, pacing, needed
        self._lock = threading.RLock()
        self._count = 0
        self._points: dict[int, Breakpoint] = {}
        self._by_place: dict[tuple[When, str], list[Breakpoint]] = {}
        self._wanted: Callable[[str], bool] | None = None
        self._listeners: list[Callable[[Held], None]] = []
        self.at: Held | None = None

    @property
    def breakpoints(self) -> tuple[Breakpoint, ...]:
        """All that are set, in the order in which they were set."""
        return tuple(self._points.values())

    def on_held(self, listener: Callable[[Held], None]) -> None:
        """Call `listener(held)` in the thread that ticks, before it holds."""
        self._listeners.append(listener)

    # --- for whoever controls the run; from any thread ---

    def set(
        self, node: str, when: str = "", outcome: str | None = None, condition: str = "", once: bool = False
    ) -> Breakpoint:
        """Set a breakpoint; see `make_breakpoint`."""
        with self._lock:
            point = make_breakpoint(self._compiled, self._count + 1, node, when, outcome, condition, once)
            self._count += 1
            self._points[point.id] = point
            self._arrange()
        return point

    def clear(self, id: int | None = None) -> tuple[int, ...]:
        """Clear one breakpoint, or all, and return the numbers of those that were cleared.

        Raises:
            UnknownNameError: there is no such number.
        """
        with self._lock:
            if id is not None and id not in self._points:
                raise UnknownNameError("breakpoint", str(id), map(str, self._points))
            cleared = tuple(self._points) if id is None else (id,)
            for number in cleared:
                del self._points[number]
            self._arrange()
        return cleared

    def run_to(self, node: str, when: str = "") -> Breakpoint:
        """Go on, and hold at `node` when the run comes there, once."""
        point = self.set(node, when, once=True)
        self._pacing.resume()
        return point

    def step(self, how: str = "tick") -> None:
        """Go on to a place that isn't far.

        Args:
            how: `tick` lets one tick through, or the one under way end. `in` goes to before the next node that begins,
                `over` to before the next that isn't below the present one, `out` to before the next that isn't below
                its parent. Without a present node, that is the running leaf.

        Raises:
            UnknownNameError: there is no such step.
        """
        if how not in STEPS:
            raise UnknownNameError("step", how, STEPS)
        if how == "tick":
            self._pacing.step()
            return
        leaves = self._compiled.leaves.items()
        here = self.at.path if self.at is not None else next((path for path, leaf in leaves if leaf.active), "/")
        outside = here if how == "over" else here.rpartition("/")[0] or "/"
        with self._lock:
            self._wanted = (lambda path: True) if how == "in" else (lambda path: not _below(path, outside))
            self._arrange()
        self._pacing.resume()

    def forget_step(self) -> None:
        """Go to no place any more that a step was for."""
        with self._lock:
            if self._wanted is not None:
                self._wanted = None
                self._arrange()

    def _arrange(self) -> None:
        places: dict[tuple[When, str], list[Breakpoint]] = {}
        for point in self._points.values():
            places.setdefault((point.when, point.node), []).append(point)
        self._by_place = places
        self._needed(bool(places) or self._wanted is not None)

    # --- as the observer ---

    def entered(self, path: str) -> None:
        point, error = self._found("before", path, None, None)
        wanted = self._wanted
        if point is not None or (wanted is not None and wanted(path)) or self._pacing.holding:
            self._hold(Held(path, "before", *_why(point), message=error), point)

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        code = failure.code if failure is not None else None
        point, error = self._found("after", path, outcome, code)
        if point is not None:
            message = error or (failure.message if failure is not None else "")
            self._hold(Held(path, "after", *_why(point), outcome, code, message), point)

    def _found(self, when: When, path: str, outcome: str | None, code: str | None) -> tuple[Breakpoint | None, str]:
        for point in self._by_place.get((when, path), ()):
            if point.outcome in (None, outcome) and point.code in (None, code):
                try:
                    if point.holds is None or point.holds():
                        return point, ""
                except GripError as error:  # as debuggers do: better to hold once too often
                    return point, f"the condition can't be computed: {error}"
        return None, ""

    def _hold(self, held: Held, point: Breakpoint | None) -> None:
        with self._lock:
            self._wanted = None
            if point is not None and point.once:
                self._points.pop(point.id, None)
            self._arrange()
            self.at = held

        def tell() -> None:
            for listener in list(self._listeners):
                listener(held)

        try:
            self._pacing.hold(tell)
        finally:
            with self._lock:
                if self.at is held:
                    self.at = None


def _below(path: str, top: str) -> bool:
    """Tell whether a node is below another one; none is below itself."""
    return path != top and (top == "/" or path.startswith(top.rstrip("/") + "/"))


def _why(point: Breakpoint | None) -> tuple[Why, int | None]:
    if point is None or point.once:
        return ("step" if point is None else "run_to"), None
    return "breakpoint", point.id
