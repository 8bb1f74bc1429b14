"""What every adapter of `ports.Touch` does, and every sensor at a wrist."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from patience import PATIENCE, until
from served_rigs import served_world
from simulated_rigs import SPOT, reach, simulated_hand_port

from grip_bt.base.failures import SensorError
from grip_bt.base.ports import Touch
from grip_bt.base.values import JointState
from grip_bt.commanders.description.load import build_robot
from grip_bt.commanders.fake import FakeArm, FakeHand


@dataclass
class TouchRig:
    """A hand that feels, and what happens to it.

    Attributes:
        take: has it hold something.
        slide: has that slide in it.
        wrench: what its wrist bears, shape (6,).
        load: the force on the wrist, shape (3,), that `take` brings; None where nobody knows how much.
    """

    port: Touch
    take: Callable[[], None]
    slide: Callable[[], None]
    wrench: Callable[[], Any]
    load: Any = None
    let_pass: Callable[[float], None] = lambda seconds: None


def alone(measure: Callable[[], Mapping[str, Any]]) -> Any:
    """Return what is measured in one frame."""
    ((_, numbers),) = measure().items()
    return numbers


@contextmanager
def fake() -> Iterator[TouchRig]:
    hand, arm = FakeHand(JointState(("finger",), [0.0])), FakeArm()

    def take() -> None:
        hand.thing, arm.load = JointState(("finger",), [0.5]), np.array([0.0, 0, -2, 0, 0, 0])
        hand.move(JointState(("finger",), [1.0]), 0.0)

    def slide() -> None:
        hand.slipping = 0.02

    yield TouchRig(hand, take, slide, arm.wrench, [0, 0, -2])


@contextmanager
def simulated() -> Iterator[TouchRig]:
    with simulated_hand_port() as rig:

        def take() -> None:
            rig.offer()
            rig.wait(rig.port.move(rig.closed, 1.0, 0.5))

        def slide() -> None:
            referee = rig.port._client.referee
            referee.move_object("thing", referee.truth()["thing"].pose.moved([0, 0, 0.004]))
            rig.let_pass(0.05)

        yield TouchRig(rig.port, take, slide, partial(alone, rig.port.wrench), let_pass=rig.let_pass)


@contextmanager
def ros(ros_robot: tuple[Any, Any]) -> Iterator[TouchRig]:
    from geometry_msgs.msg import WrenchStamped
    from std_msgs.msg import Float64MultiArray

    from grip_bt.ros.controllers import TopicTouch, TopicWrench
    from grip_bt.task.catalog.ros_config import ControllerConfig, SignalConfig

    bus, _ = ros_robot
    slip = SignalConfig(topic="/touch/slip", message="std_msgs/msg/Float64MultiArray", field="data[1]")
    told = ControllerConfig(positions="/f", contacts={"tip": SignalConfig(topic="/touch/tip")}, slips={"tip": slip})
    hand = TopicTouch(bus, FakeHand(JointState(("finger",), [0.0])), told, PATIENCE)
    wrench, said = TopicWrench(bus, "/touch/wrist", PATIENCE), {"tip": 0.0, "slip": 0.0}

    def say(**changed: float) -> None:
        said.update(changed)
        force = WrenchStamped()
        force.header.frame_id, force.wrench.force.z = "world", -said["tip"]
        for topic, message in {"/touch/tip": force, "/touch/wrist": force}.items():
            bus.writer("geometry_msgs/msg/WrenchStamped", topic).publish(message, 1).wait(PATIENCE)
        told = Float64MultiArray(data=[9.0, said["slip"]])
        bus.writer("std_msgs/msg/Float64MultiArray", "/touch/slip").publish(told, 1).wait(PATIENCE)
        until(lambda: _heard(hand) == (said["tip"], said["slip"]) and heard_wrench() == -said["tip"], "it isn't heard")

    def heard_wrench() -> float | None:
        try:
            return float(alone(wrench)[2])
        except SensorError:
            return None

    with pytest.raises(SensorError, match="/touch/silent: nothing was heard"):
        TopicWrench(bus, "/touch/silent", PATIENCE)()
    say()
    yield TouchRig(hand, lambda: say(tip=2.0), lambda: say(slip=0.02), partial(alone, wrench), [0, 0, -2])


@contextmanager
def served(folder: Path) -> Iterator[TouchRig]:
    """Read as on a robot, by what `grip sim` says to put into grip.yaml, what that serves."""
    from grip_bt.ros.controllers import TopicTouch, TopicWrench

    with served_world(folder) as (world, bus, told):
        simulation = world.simulation
        reach(simulation)
        hand, states = simulation.hand("hand"), build_robot("panda_allegro").named_states["hand"]
        touch = TopicTouch(bus, hand, told["right_hand"], PATIENCE)
        wrench = TopicWrench(bus, told["right"].wrench, PATIENCE)
        until(lambda: _says(touch.contacts) and _says(touch.slips) and _says(wrench), "it isn't heard")

        def take() -> None:
            simulation.referee.move_object("thing", SPOT)
            held = hand.move(states["closed"], 1.0, 0.5)
            assert held.wait(PATIENCE)
            until(touch.contacts, "no contact is heard of")

        def slide() -> None:
            simulation.referee.move_object("thing", simulation.referee.truth()["thing"].pose.moved([0, 0, 0.004]))
            until(lambda: max(touch.slips().values(), default=0.0) > 5e-3, "it isn't heard that it slides")

        yield TouchRig(touch, take, slide, partial(alone, wrench), let_pass=simulation.settle)


def _says(measure: Callable[[], object]) -> bool:
    try:
        measure()
    except SensorError:
        return False
    return True


def _heard(hand: Touch) -> tuple[float, float] | None:
    try:
        return hand.contacts().get("tip", 0.0), hand.slips().get("tip", 0.0)
    except SensorError:
        return None


@pytest.fixture(
    params=[
        "fake",
        pytest.param("simulated", marks=pytest.mark.sim),
        pytest.param("ros", marks=(pytest.mark.ros, pytest.mark.slow)),
        pytest.param("served", marks=(pytest.mark.ros, pytest.mark.sim, pytest.mark.slow)),
    ]
)
def rig(request: pytest.FixtureRequest) -> Iterator[TouchRig]:
    make: Any = globals()[request.param]
    needs = {"ros": ["ros_robot"], "served": ["tmp_path"]}.get(request.param, [])
    with make(*map(request.getfixturevalue, needs)) as made:
        yield made


def test_a_hand_feels_what_it_holds_and_what_slides_in_it(rig):
    assert isinstance(rig.port, Touch)
    assert not rig.port.contacts()
    assert not rig.port.slips()
    rig.take()
    assert rig.port.contacts()
    for _ in range(4):
        rig.port.slips()
        rig.let_pass(0.1)
    assert max(rig.port.slips().values(), default=0.0) < 5e-3
    rig.slide()
    assert max(rig.port.slips().values()) > 5e-3
    # Two topics are of two moments.
    until(lambda: set(rig.port.slips()) <= set(rig.port.contacts()), "what slides touches nothing")


def test_a_wrist_feels_a_load(rig):
    rig.let_pass(0.5)
    assert rig.wrench() == pytest.approx(np.zeros(6), abs=0.05)
    rig.take()
    assert rig.wrench().shape == (6,)
    if rig.load is not None:
        assert rig.wrench()[:3] == pytest.approx(rig.load)
