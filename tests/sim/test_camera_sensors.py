"""Cameras on links, what their sensors add, how late they are, and films of the world."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module

import cv2
import numpy as np
import pytest
from pydantic import ValidationError
from same_run import compared
from test_repeated_runs import NODES, PROJECT, TASK

from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.base.errors import GripError, UnknownNameError
from grip_bt.base.values import Pose, Trajectory
from grip_sim.cameras.rig import APART
from grip_sim.noise import PRESETS, NoiseSpec
from grip_sim.simulation import start_simulation
from grip_sim.specs import CameraSpec, ObjectSpec, WorldSpec
from grip_sim.worlds import load_world

pytestmark = pytest.mark.sim
WRIST = CameraSpec("wrist", 64, 48, 1.0, (0.05, 0.0, 0.03), target=(0.05, 0.0, 0.5), link="panda_link8", far=3.0)
SMALL = CameraSpec(width=160, height=120, renderer="raster")
FOCAL = 600.0


def world_of(*cameras, **fields):
    from grip_sim.world import World

    return World(replace(load_world("table", 1), cameras=cameras, **fields))


def same(one, two):
    return np.array_equal(one.image, two.image) and np.array_equal(one.depth, two.depth)


# --- where cameras are ---


def test_a_camera_looks_at_its_target_with_up_above():
    info = CameraSpec(position=(1.0, 0.5, 0.8), target=(0.4, 0.0, 0.1)).info()
    assert info.project(np.array([[0.4, 0.0, 0.1]]))[0] == pytest.approx([160, 120])
    (_, low), (_, high) = info.project(np.array([[0.4, 0.0, 0.1], [0.4, 0.0, 0.2]]))
    assert high < low
    straight = CameraSpec(target=(0.53, 0.14, 0.0)).info()
    assert straight.pose.matrix() == pytest.approx(CameraSpec().info().pose.matrix(), abs=1e-12)


def test_a_camera_on_a_link_goes_where_the_link_goes():
    world = world_of(WRIST)
    seen = []
    for turn in (0.0, 0.8):
        world.robot.place({"panda_joint1": turn})
        world.step()
        frame = world.cameras.look("wrist")
        carrier = world.link_pose("panda_link8")
        assert frame.pose.matrix() == pytest.approx((carrier @ WRIST.info().pose).matrix(), abs=1e-6)
        assert frame.time == world.time
        seen.append(frame)
    assert np.linalg.norm(seen[0].pose.position - seen[1].pose.position) > 0.2
    assert not np.array_equal(seen[0].depth, seen[1].depth)
    # what it sees of the table lies at the table's height, in world
    for frame in seen:
        rays = WRIST.info().rays() @ frame.pose.rotation().T
        heights = (frame.pose.position + rays * frame.depth[..., None])[frame.labels == frame.names.index("table")][
            :, 2
        ]
        assert heights.size == 0 or np.abs(heights[np.isclose(heights, 0, atol=0.05)]).max() < 1e-5


def test_frames_and_geometry_that_are_served_are_of_where_the_link_is():
    with start_simulation(replace(load_world("table", 1), cameras=(WRIST, SMALL))) as simulation:
        camera = simulation.camera("wrist")
        before, frame = camera.info(), camera.capture()
        assert frame.wait(30.0)
        assert frame.result().depth.info.pose.matrix() == pytest.approx(before.pose.matrix(), abs=1e-9)
        hand = simulation.executor("arm")
        start = hand.state()
        goal = start.position + np.eye(len(start.position))[0] * 0.3
        moved = hand.execute(Trajectory(start.names, np.array([0.0, 2.0]), np.stack([start.position, goal])))
        moved.wait()
        after = camera.info()
        assert np.linalg.norm(after.pose.position - before.pose.position) > 0.1
        assert simulation.camera("overhead").info().pose == SMALL.info().pose


def test_a_camera_on_a_link_that_is_not_there_is_refused():
    with pytest.raises(UnknownNameError, match="panda_link8"):
        world_of(replace(WRIST, link="panda_lnk8"))
    with pytest.raises(ValidationError, match="can't look at where it is"):
        CameraSpec(position=(1.0, 0.0, 0.0), target=(1.0, 0.0, 0.0))


# --- noise ---


def flat(depth, height=240, width=320):
    return np.full((height, width), depth, np.float32), np.ones((height, width))


@pytest.mark.parametrize("depth", [0.5, 1.0, 2.0, 4.0])
@pytest.mark.parametrize("name", sorted(PRESETS))
def test_noise_grows_as_the_formula_of_its_sensor_says(name, depth):
    sensor = replace(PRESETS[name], unit=0.0, dropout=0.0, nearest=0.0)
    found = sensor.on_depth(*flat(depth), FOCAL, [1, 2, 3])
    if name == "realsense":  # Intel: RMS = z^2 * subpixel / (f * B)
        expected = depth**2 * sensor.subpixel / (FOCAL * sensor.baseline)
    else:
        expected = sensor.constant + sensor.linear * depth
    assert found.std() == pytest.approx(expected, rel=0.02)
    assert found.mean() == pytest.approx(depth, abs=5 * expected / np.sqrt(found.size))


def test_a_slanted_surface_is_noisier_and_a_grazing_one_returns_nothing():
    sensor = NoiseSpec(constant=1e-3, slant=0.5, grazing=1.3)
    depth, _ = flat(1.0)
    slanted = sensor.on_depth(depth, np.full(depth.shape, np.cos(np.pi / 4)), FOCAL, [1])
    assert slanted.std() == pytest.approx(1.5e-3, rel=0.02)
    assert not sensor.on_depth(depth, np.full(depth.shape, np.cos(1.31)), FOCAL, [1]).any()
    assert sensor.on_depth(depth, np.full(depth.shape, np.cos(1.29)), FOCAL, [1]).all()


def test_depth_comes_in_units_and_pixels_drop_out_as_often_as_is_said():
    found = NoiseSpec(constant=2e-3, unit=1e-3, dropout=0.1).on_depth(*flat(1.0), FOCAL, [5])
    assert (found == 0).mean() == pytest.approx(0.1, abs=0.005)
    steps = found[found > 0] * 1000.0
    assert np.abs(steps - np.round(steps)).max() < 1e-3
    assert not NoiseSpec(nearest=0.5).on_depth(*flat(0.4), FOCAL, [5]).any()


def test_edges_bleed_and_the_rest_stays():
    depth, cosine = flat(1.0)
    depth[:, 160:] = 2.0
    found = NoiseSpec(bleeding=1.0).on_depth(depth, cosine, FOCAL, [7])
    edge = found[:, 159:161]
    between = (edge > 1.0) & (edge < 2.0)
    assert np.array_equal(np.delete(found, [159, 160], axis=1), np.delete(depth, [159, 160], axis=1))
    assert between.mean() == pytest.approx(0.5, abs=0.08)
    assert (edge == 0).mean() == pytest.approx(0.5, abs=0.08)


def test_nothing_is_added_where_nothing_is_and_nothing_by_default():
    assert not PRESETS["kinect2"].on_depth(*flat(0.0), FOCAL, [1]).any()
    depth, cosine = flat(1.234)
    assert np.array_equal(NoiseSpec().on_depth(depth, cosine, FOCAL, [1]), depth)
    assert CameraSpec().noise is None


def test_a_frame_says_a_pose_that_is_off_as_much_as_is_said_and_the_camera_stays_where_it_is():
    sensor, true = NoiseSpec(misplaced=0.004, misturned=0.01), Pose((1.0, 2.0, 3.0), (0.5, 0.5, -0.5, 0.5))
    off = [true.inverse() @ sensor.on_pose(true, [1, 2, k]) for k in range(400)]
    assert np.std([pose.position for pose in off]) == pytest.approx(0.004, rel=0.1)
    assert np.std([pose.rotation_vector() for pose in off]) == pytest.approx(0.01, rel=0.1)
    assert NoiseSpec().on_pose(true, [1]) is true
    world = world_of(replace(SMALL, noise=sensor))
    assert world.cameras.look("overhead").pose != world.cameras.pose("overhead") == SMALL.info().pose


def test_the_same_seed_gives_the_same_frames_bit_by_bit_and_another_one_others():
    noisy = replace(SMALL, noise=PRESETS["realsense"])
    first = world_of(noisy)
    frames = [first.cameras.look("overhead"), first.cameras.look("overhead")]
    second = world_of(noisy)
    second.cameras.view("overhead")  # a look without faults is no frame of the sensor
    again = [second.cameras.look("overhead"), second.cameras.look("overhead")]
    assert same(frames[0], again[0])
    assert same(frames[1], again[1])
    assert not same(frames[0], frames[1])
    assert not same(frames[0], world_of(noisy, seed=2).cameras.look("overhead"))
    clean = world_of(SMALL).cameras.look("overhead")
    off = (frames[0].depth - clean.depth)[frames[0].depth > 0]
    expected = PRESETS["realsense"].deviation(clean.depth, SMALL.info().matrix[0, 0], 1.0)
    assert np.median(np.abs(off)) < 3 * np.median(expected)


def test_a_sensor_is_given_by_its_name_or_by_its_fields_and_travels_as_json():
    from pydantic import TypeAdapter

    read = TypeAdapter(CameraSpec).validate_python
    assert read({"noise": "kinect2"}).noise == PRESETS["kinect2"]
    assert read({"noise": {"constant": 0.001}}).noise == NoiseSpec(constant=0.001)
    with pytest.raises(ValidationError, match="there are realsense, kinect2"):
        read({"noise": "kinect"})
    spec = WorldSpec(cameras=(replace(WRIST, noise=PRESETS["realsense"]),))
    assert WorldSpec.from_json(spec.to_json()) == spec


def test_a_late_camera_shows_the_world_as_it_was():
    thing = ObjectSpec("thing", "box", 0.03, 0.1, (0.53, 0.14, 0.4))
    late = replace(SMALL, name="late", noise=NoiseSpec(latency=0.1))
    world = world_of(SMALL, late, objects=(thing,))
    depths, kept = {}, world.kept()
    for _ in range(60):
        world.step()
        depths[round(world.time, 6)] = world.cameras.look("overhead").depth
    frame = world.cameras.look("late")
    assert 0.1 <= world.time - frame.time + 1e-9 <= 0.1 + APART
    assert np.array_equal(frame.depth, depths[round(frame.time, 6)])
    assert not np.array_equal(frame.depth, depths[round(world.time, 6)])
    world.put_back(kept)  # what was before isn't seen any more
    assert np.array_equal(world.cameras.look("late").depth, world.cameras.look("overhead").depth)


# --- films ---


def filmed(folder, target, film):
    journal = folder / "runs.sqlite"
    shown = (
        {"video": folder / "out.mp4", "picture": folder / "out.png", "view": "1.4,0.6,0.9,0.4,0,0.2"} if film else {}
    )
    with open_session(folder / "task.yaml", RunOptions(target=target, seed=3, journal=journal, **shown)) as session:
        result = session.runner.run()
        return (journal, session.runner.run_id), result


@pytest.mark.parametrize("target", ["bt", "sm"])
def test_a_run_that_is_filmed_is_the_same_run(tmp_path, target):
    (tmp_path / "nodes").mkdir()
    (tmp_path / "nodes" / "own.py").write_text(NODES)
    (tmp_path / "grip.yaml").write_text(PROJECT)
    (tmp_path / "task.yaml").write_text(TASK)
    (one, first), (two, second) = (filmed(tmp_path, target, film) for film in (False, True))
    assert (first.status, first.duration) == (second.status, second.duration)
    assert first.status == "success"
    assert compared(one, two).differences == ()
    film = cv2.VideoCapture(str(tmp_path / "out.mp4"))
    assert film.get(cv2.CAP_PROP_FPS) == 25
    assert film.get(cv2.CAP_PROP_FRAME_COUNT) == pytest.approx(25 * second.duration, abs=3)
    assert film.read()[1].shape == (480, 640, 3)
    picture = cv2.imread(str(tmp_path / "out.png"))
    assert picture.shape == (480, 640, 3)
    assert picture.std() > 20


def test_a_film_that_can_not_be_is_refused_before_anything_moves(tmp_path):
    with start_simulation(replace(load_world("table", 0), cameras=(SMALL,))) as simulation:
        for wrong in ({"video": tmp_path / "gone" / "a.mp4"}, {"picture": tmp_path / "a.txt"}, {"view": "overhaed"}):
            with pytest.raises(GripError), simulation.filmed(**{"view": "", "picture": tmp_path / "a.png"} | wrong):
                pytest.fail("it was begun")
        with simulation.filmed("", picture=tmp_path / "a.png"):
            simulation.settle(0.1)
    assert cv2.imread(str(tmp_path / "a.png")).shape == (120, 160, 3)


def test_only_a_simulated_world_is_filmed(tmp_path):
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    (tmp_path / "task.yaml").write_text(
        "grip: 1\nname: t\nroot: {kind: sequence, children: {w: {node: flow/wait, with: {seconds: 0.01}}}}\n"
    )
    with pytest.raises(GripError, match="only a simulated world"):
        with open_session(tmp_path / "task.yaml", RunOptions(picture=tmp_path / "a.png")):
            pass


def test_where_no_driver_is_auto_draws_triangles_without_a_trial(monkeypatch, tmp_path):
    render_support = import_module("grip_sim.cameras")  # the package has a function of that name
    monkeypatch.setenv("VK_ICD_FILENAMES", str(tmp_path / "none.json"))
    monkeypatch.setattr(render_support, "_tried", lambda: pytest.fail("it was tried"))
    render_support.vulkan_works.cache_clear()
    try:
        assert not render_support.vulkan_works()
        assert "OpenCV" in render_support.render_support()
    finally:
        render_support.vulkan_works.cache_clear()
