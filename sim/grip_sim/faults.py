"""What goes wrong on purpose in a simulated world: drops, stuck joints, blind cameras, at times, at nodes, by chance.

Nothing here imports SAPIEN. Everything is drawn by the world's seed, the fault's name, and how often it was due, so
that the same run meets the same faults.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple
from zlib import crc32

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field, model_validator

from grip_bt.base.errors import DocumentError, GripError, UnknownNameError
from grip_bt.base.yaml.models import Finite, NotNegative, Positive, Settings, check_model
from grip_bt.base.yaml.tree import parse
from grip_bt.commanders.description.robot import RobotDescription

if TYPE_CHECKING:  # who reads what faults a world has must not import sapien
    from grip_sim.world import World

Vector = tuple[Finite, Finite, Finite]
Camera = Literal["blackout", "freeze", "late"]
FaultKind = Literal["drop", "push", "stuck", "limit", "abort", "light", Camera, "component_death", "component_hang"]
SLIPPING = 0.5
"""How long a dropped object passes through hands by default [s]."""


def rising(span: tuple[float, float]) -> tuple[float, float]:
    """Return a range; ValueError where its first number isn't the smaller one."""
    if not span[0] <= span[1]:
        raise ValueError(f"from {span[0]:g} to {span[1]:g} isn't a range: the first number is the smaller one")
    return span


Range = Annotated[tuple[Finite, Finite], AfterValidator(rising)]


class _Kind(NamedTuple):
    """What `of` names, if anything; the field that only it has; what it is of without `of`, where it may be."""

    of: str = ""
    takes: str = ""
    everything: str = ""


_KINDS: Mapping[str, _Kind] = {
    "drop": _Kind("object", "", "nothing: no hand holds anything"),
    "push": _Kind("object", "by"),
    "stuck": _Kind("joint"),
    "limit": _Kind("joint", "between"),
    "abort": _Kind("group", "", "every motion"),
    "blackout": _Kind("camera", "", "every camera"),
    "freeze": _Kind("camera", "", "every camera"),
    "late": _Kind("camera", "lag", "every camera"),
    "light": _Kind("", "factor", "everything"),
    "component_death": _Kind("component"),
    "component_hang": _Kind("component"),
}


class Fault(Settings):
    """Something that goes wrong at a time, or when a node begins."""

    fault: FaultKind
    """`drop`: an object passes through hands. `push`: its velocity changes. `stuck`: a joint stays where it is, and its
    motion is aborted. `limit`: it meets a stop. `abort`: a controller gives up. `blackout`, `freeze`, `late`: a camera
    sees nothing, repeats its last frame with new stamps, shows old frames with their stamps. `light`: colours are
    multiplied. `component_death`, `component_hang`: a component's server is killed, or suspended."""
    of: str = ""
    """Object, joint, group, camera or component; without it what is held, every arm and hand, or every camera."""
    node: str = ""
    """Path of the node with whose beginning it is due; without it, it is due once."""
    at: NotNegative | Annotated[tuple[NotNegative, NotNegative], AfterValidator(rising)] = 0.0
    """How long after the start, or the node's beginning [simulated s]; or a range, in which the seed draws."""
    chance: Annotated[float, Field(ge=0, le=1)] = 1.0
    """Probability that it happens when due."""
    times: Annotated[int, Field(ge=1)] | None = None
    """How often it happens at most."""
    lasts: Positive | None = None
    """For how long [s of simulated time]; to the end without it. A drop: 0.5 s."""
    by: Vector | None = None
    """Of a push: what the object's velocity changes by, in world [m/s]."""
    between: Range | None = None
    """Of a limit: where the joint can go [rad or m]."""
    lag: Positive | None = None
    """Of `late`: how old the frames are [s], or up to 1/60 s more."""
    factor: Positive | None = None
    """Of light: what colours are multiplied with."""

    @model_validator(mode="after")
    def _has_what_it_needs(self) -> Fault:
        for name, kind in _KINDS.items():
            if kind.takes and (getattr(self, kind.takes) is not None) != (self.fault == name):
                word = "needs" if self.fault == name else "takes no"
                raise ValueError(f"the fault `{self.fault}` {word} `{kind.takes}`")
        kind = _KINDS[self.fault]
        if not self.of and not kind.everything:
            raise ValueError(f"the fault `{self.fault}` needs `of`: the {kind.of}'s name")
        return self


NOWHERE = (np.inf, -np.inf)
"""The range of a joint that is stuck."""


def check_faults(
    faults: Mapping[str, Fault],
    robot: RobotDescription,
    objects: Collection[str],
    cameras: Collection[str],
    components: Collection[str],
) -> Iterator[GripError]:
    """Yield the faults that name what isn't there."""
    there: dict[str, Collection[str]] = {"object": objects, "joint": robot.drives, "group": robot.groups}
    there |= {"camera": cameras, "component": components}
    for name, fault in faults.items():
        kind = _KINDS[fault.fault].of
        if fault.of and not kind:
            yield GripError(f"faults/{name}: the fault `{fault.fault}` takes no `of`: it is everywhere")
        elif fault.of and fault.of not in there[kind]:
            yield UnknownNameError(kind, fault.of, there[kind], f"faults/{name}/of")


@dataclass
class _Due:
    """A fault that is to begin, or that is on, at a time [s]."""

    name: str
    time: float
    begins: bool = True
    on: tuple[str, ...] = ()


class Faults:
    """Has the faults of a world happen.

    Attributes:
        on_event: told of each that begins or is over: its name, what happened, whether it is over.
    """

    def __init__(self, faults: Mapping[str, Fault], seed: int, world: World):
        self._faults, self._seed, self._world = dict[str, Fault](), seed, world
        self.due: list[_Due] = []
        """What is to begin, or to end."""
        self._counts, self._happened = dict[str, int](), dict[str, int]()
        self._on: dict[str, Fault] = {}
        self.on_event: Callable[[str, str, bool], None] = lambda name, words, over: None
        for name, fault in faults.items():
            self.add(name, fault)

    def add(self, name: str, fault: Fault) -> None:
        """Have another fault; its times are from now on."""
        self._faults[name] = fault
        self._counts[name] = self._happened[name] = 0
        if not fault.node:
            self._draw(name, self._world.time)

    def forget(self, name: str) -> None:
        """Leave an object alone that isn't there any more."""
        self._faults = {key: fault for key, fault in self._faults.items() if fault.of != name}
        self.due = [due for due in self.due if due.name in self._faults]
        for due in self.due:
            due.on = tuple(each for each in due.on if each != name)

    def entered(self, node: str) -> None:
        """A node of the task begins."""
        for name, fault in self._faults.items():
            if fault.node == node:
                self._draw(name, self._world.time)
        self.stepped()

    def stepped(self) -> None:
        """Begin what is due, and end what is over."""
        ready = [due for due in self.due if due.time <= self._world.time + 1e-9]
        self.due = [due for due in self.due if due not in ready]
        for due in ready:
            self._begin(due) if due.begins else self._end(due)

    @property
    def any(self) -> bool:
        """Whether there is one now."""
        return bool(self._on)

    def aborted(self, groups: Iterable[str]) -> str:
        """Return why a controller of one of these groups gives up now, or an empty string."""
        groups = set(groups)
        for name, fault in self._on.items():
            if fault.fault == "abort" and (not fault.of or fault.of in groups):
                return f"the controller has aborted (fault {name!r})"
        return ""

    def of_camera(self, kind: Camera, camera: str) -> Fault | None:
        """Return the fault of a kind that a camera has now."""
        found = (f for f in self._on.values() if f.fault == kind and f.of in ("", camera))
        return next(found, None)

    @property
    def brightness(self) -> float:
        """What colours are multiplied with now."""
        return float(np.prod([f.factor for f in self._on.values() if f.factor is not None]))

    def _draw(self, name: str, now: float) -> None:
        fault = self._faults[name]
        rng = np.random.default_rng([self._seed, crc32(name.encode()), self._counts[name]])
        self._counts[name] += 1
        happens, wait = rng.random() < fault.chance, fault.at
        if happens:
            self.due.append(_Due(name, now + (wait if isinstance(wait, float) else float(rng.uniform(*wait)))))

    def _begin(self, due: _Due) -> None:
        fault, name = self._faults[due.name], due.name
        if fault.times is not None and self._happened[name] >= fault.times:
            return
        self._happened[name] += 1
        lasts, on = fault.lasts, tuple(name for name in [fault.of] if name)
        if fault.fault == "drop":
            on, lasts = on or tuple(self._world.held_objects()), lasts or SLIPPING
            for thing in on:
                self._world.let_slip(thing, True)
        elif fault.by is not None:
            self._world.push(fault.of, fault.by)
        elif fault.fault in ("stuck", "limit"):
            self._world.robot.restrict(fault.of, fault.between or NOWHERE)
        else:
            self._on[name] = fault
            lasts = lasts or 0.0 if fault.fault == "abort" else lasts
        self.on_event(name, f"{fault.fault} of {', '.join(on) or _KINDS[fault.fault].everything}", False)
        if lasts is not None and fault.fault != "push":
            self.due.append(_Due(name, self._world.time + lasts, False, on))

    def _end(self, due: _Due) -> None:
        fault = self._faults[due.name]
        for thing in due.on if fault.fault == "drop" else ():
            self._world.let_slip(thing, False)
        if fault.fault in ("stuck", "limit"):
            self._world.robot.restrict(fault.of, None)
        self._on.pop(due.name, None)
        if fault.lasts is not None:
            self.on_event(due.name, f"{fault.fault} is over", True)


def darkened(image: NDArray[np.uint8], factor: float) -> NDArray[np.uint8]:
    """Return colours of shape (height, width, 3) uint8, multiplied and kept within 0-255."""
    return image if factor == 1.0 else np.clip(np.rint(image * factor), 0, 255).astype(np.uint8)


class _Given(Settings):
    faults: dict[str, Fault]


def read_faults(given: Sequence[str]) -> dict[str, Fault]:
    """Return by name faults that are given one by one, `NAME: {fault: drop, node: attempt/lift}` as in a world's file.

    Raises DocumentError where one isn't a fault, or two have one name.
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
