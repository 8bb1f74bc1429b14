"""Drawers, buttons and screw caps move by the laws that are stated, and the referee knows how far."""

import numpy as np
import pytest
from pydantic import ValidationError

from grip_bt.app.project.worlds import WorldCondition, counted
from grip_sim.articulated.model import ArticulatedConfig
from grip_sim.specs import WorldSpec

pytestmark = pytest.mark.sim
pytest.importorskip("sapien")
AT = (0.5, 0.0, 0.0)
TURN = 2 * np.pi


def world_of(**articulated):
    from grip_sim.world import World

    spec = WorldSpec(robot="panda", objects=(), cameras=(), articulated=articulated)
    return World(spec)


def steps(world, seconds, force=None, until=None):
    """Step; `force` applies some before each step. Return the time when `until` was first true."""
    for _ in range(round(seconds / world.spec.dt)):
        if force is not None:
            force()
        world.step()
        if until is not None and until():
            return world.time
    return None


def pull(body, force, point=(0.0, 0.0, 0.0)):
    return lambda: body.add_force_at_point(
        np.array(force, float), np.add(body.cmass_local_pose.p + body.entity_pose.p, point)
    )


@pytest.mark.parametrize("friction", [1.0, 3.0, 6.0])
def test_a_drawer_moves_when_it_is_pulled_harder_than_its_friction_and_rests_otherwise(friction):
    for part, moves in ((0.9, False), (1.1, True)):
        world = world_of(cabinet=ArticulatedConfig(drawer={"friction": friction}, at=AT))
        steps(world, 0.2)
        steps(world, 0.5, pull(world.articulated["cabinet"].body.links[1], (-part * friction, 0, 0)))
        assert (world.measures()["cabinet_opened"] > 1e-3) == moves


def test_a_drawer_that_is_pushed_open_stops_after_its_energy_and_never_opens_further_than_it_can():
    world = world_of(cabinet=ArticulatedConfig(drawer={"friction": 3.0, "travel": 0.2}, at=AT))
    drawer = world.articulated["cabinet"].body
    drawer.set_qvel(np.array([0.8], np.float32))
    steps(world, 1.0)
    assert world.measures()["cabinet_opened"] == pytest.approx(0.8**2 / 2 / 3.0, rel=0.03)
    drawer.set_qvel(np.array([3.0], np.float32))
    steps(world, 1.0)
    assert world.measures()["cabinet_opened"] <= 0.2 + 1e-3


def test_a_drawer_is_beside_its_cabinet_and_not_in_it():
    """It stands in walls that planners avoid; nothing touches while nobody pulls."""
    from grip_sim.world import World
    from grip_sim.worlds import WorldFile, arrange

    said = {"grip": 1, "articulated": {"cabinet": {"drawer": {}, "at": AT, "yaw": 0.4}}}
    spec = arrange(WorldFile.model_validate(said), 0, None, "panda")
    world = World(spec)
    steps(world, 0.2)
    assert {box.name for box in spec.boxes} == {
        f"cabinet_{wall}" for wall in ("bottom", "top", "left", "right", "back")
    }
    assert not [c for c in world.contacts() if "cabinet_drawer" in c[:2]]
    steps(world, 0.5, pull(world.articulated["cabinet"].body.links[1], (-5 * np.cos(0.4), -5 * np.sin(0.4), 0)))
    assert world.measures()["cabinet_opened"] == pytest.approx(0.16, abs=2e-3)


@pytest.mark.parametrize("force", [1.0, 2.0])
def test_a_button_clicks_at_its_force_once_a_press_and_comes_back(force):
    world = world_of(bell=ArticulatedConfig(button={"force": force}, at=AT))
    key = world.articulated["bell"].body.links[1]
    steps(world, 0.3, pull(key, (0, 0, -0.9 * force)))
    assert world.measures()["bell_presses"] == 0
    for count in (1, 2):
        steps(world, 0.3, pull(key, (0, 0, -1.15 * force)))
        assert world.measures()["bell_presses"] == count
        steps(world, 0.3)
        assert float(world.articulated["bell"].body.get_qpos()[0]) < 1e-4


def turned(world, torque):
    """Return what turns the cap with a torque [N m], by two forces at its rim."""
    cap = world.articulated["bottle"].body.links[2]
    arm = 0.018

    def force():
        if cap.collision_shapes[0].get_collision_groups()[0]:
            for side in (1, -1):
                pull(cap, (0, side * torque / arm / 2, 0), (side * arm, 0, 0))()

    return force


@pytest.mark.parametrize(("pitch", "turns"), [(0.003, 1.5), (0.006, 0.5)])
def test_a_cap_rises_by_its_pitch_comes_off_after_its_turns_and_is_free_then(pitch, turns):
    said = ArticulatedConfig(screw_bottle={"pitch": pitch, "turns": turns, "held": True}, at=AT)
    world = world_of(bottle=said)
    body, errors = world.articulated["bottle"].body, []

    def off():
        lift, angle = body.get_qpos()
        errors.append(abs(lift - pitch * angle / TURN))
        return world.measures()["bottle_off"] == 1.0

    assert steps(world, 2.0, turned(world, 0.06), off) is not None
    assert max(errors) < 1e-4
    free = world.articulated["bottle"]._free
    assert free.entity_pose.p[2] == pytest.approx(pitch * turns, abs=1e-3)
    free.set_linear_velocity(np.array([0.3, 0.0, 0.5]))
    steps(world, 1.0)
    assert np.hypot(*np.subtract(free.entity_pose.p[:2], AT[:2])) > 0.05
    assert world.measures()["bottle_turns"] == turns


@pytest.mark.parametrize("load", [(0, 0, 15.0), (0, 0, -15.0)])
def test_a_thread_locks_itself_against_pulling_and_pushing(load):
    world = world_of(bottle=ArticulatedConfig(screw_bottle={"held": True}, at=AT))
    steps(world, 0.3, pull(world.articulated["bottle"].body.links[2], load))
    assert world.measures()["bottle_turns"] == pytest.approx(0.0, abs=0.01)


def test_a_bottle_that_nobody_holds_stands_and_turns_with_its_cap():
    world = world_of(bottle=ArticulatedConfig(screw_bottle={}, at=AT))
    steps(world, 0.5)
    bottle = world.articulated["bottle"].body.links[0]
    assert np.allclose(bottle.entity_pose.p, AT, atol=1e-3)
    steps(world, 0.5, turned(world, 0.04))  # less than the thread's friction
    measures = world.measures()
    assert measures["bottle_off"] == 0.0
    assert measures["bottle_turns"] == pytest.approx(0.0, abs=0.01)
    assert measures["bottle_twisted"] < 0.01
    assert measures["bottle_slid"] < 0.01
    assert measures["bottle_rise"] == pytest.approx(0.0, abs=1e-3)


def test_a_world_with_articulated_objects_goes_on_as_it_was_kept():
    said = {
        "cabinet": ArticulatedConfig(drawer={}, at=(0.6, 0.3, 0)),
        "bell": ArticulatedConfig(button={}, at=(0.6, -0.2, 0)),
        "bottle": ArticulatedConfig(screw_bottle={"turns": 0.3, "held": True}, at=AT),
    }
    world = world_of(**said)
    bell = pull(world.articulated["bell"].body.links[1], (0, 0, -3.0))
    turn = turned(world, 0.06)
    world.articulated["cabinet"].body.set_qvel(np.array([0.5], np.float32))
    steps(world, 1.0, lambda: (bell(), turn()))
    again = world_of(**said)
    again.put_back(world.kept())
    assert again.measures() == pytest.approx(world.measures(), abs=1e-5)
    assert world.measures()["bottle_off"] == 1.0
    assert world.measures()["bell_presses"] == 1.0


def test_a_camera_sees_the_parts_and_a_cap_where_it_went():
    from grip_sim.specs import CameraSpec
    from grip_sim.world import World

    camera = CameraSpec("front", 160, 120, 0.6, (0.9, -0.5, 0.3), target=(0.5, 0.0, 0.1))
    said = ArticulatedConfig(screw_bottle={"turns": 0.1, "held": True}, at=AT)
    world = World(WorldSpec(robot="panda", objects=(), cameras=(camera,), articulated={"bottle": said}))

    def seen():
        frame = world.cameras.look("front")
        rows, _ = np.nonzero(frame.labels == frame.names.index("bottle_cap"))
        return float(rows.mean())

    before = seen()
    steps(world, 1.0, turned(world, 0.06), lambda: world.measures()["bottle_off"] == 1.0)
    free = world.articulated["bottle"]._free
    free.set_linear_velocity(np.array([0, 0, 1.5]))
    steps(world, 0.08)
    assert seen() < before - 5


def test_a_condition_of_a_world_may_ask_how_far_things_are():
    spec = WorldSpec(articulated={"cabinet": ArticulatedConfig(drawer={}, at=AT)})
    condition = WorldCondition("cabinet_opened > 0.1", (), spec.measures, "judge/open", "w")
    assert not condition.holds(counted((), (), {"cabinet_opened": 0.05}))
    assert condition.holds(counted((), (), {"cabinet_opened": 0.15}))


@pytest.mark.parametrize(
    ("said", "wrong"),
    [
        ({"at": AT}, "give exactly one of"),
        ({"at": AT, "drawer": {}, "button": {}}, "give exactly one of"),
        ({"at": AT, "drawer": {"travel": 0.5}}, "by less than its depth"),
        ({"at": AT, "screw_bottle": {"pitch": 0}}, "greater than 0"),
    ],
)
def test_what_cannot_be_is_refused(said, wrong):
    with pytest.raises(ValidationError, match=wrong):
        ArticulatedConfig.model_validate(said)
