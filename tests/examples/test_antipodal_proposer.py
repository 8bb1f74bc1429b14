"""The example's proposer on clouds of known shapes, seen by a pinhole camera from above."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

PROPOSER = Path(__file__).parents[2] / "examples/components/antipodal_grasps/proposer.py"
CAMERA = np.array([0.53, 0.14, 1.30])


@pytest.fixture(scope="module")
def proposer():
    sys.path.insert(0, str(PROPOSER.parent))
    spec = importlib.util.spec_from_file_location("antipodal_proposer_under_test", PROPOSER)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name], sys.modules["splitting"]
    sys.path.remove(str(PROPOSER.parent))


def rays(step=0.0018):
    """Directions of a camera that looks straight down: 240 x 320 pixels, 0.44 rad."""
    v, u = np.meshgrid((np.arange(240) - 119.5) * step, (np.arange(320) - 159.5) * step, indexing="ij")
    return np.stack([-v, -u, -np.ones_like(u)], axis=-1).reshape(-1, 3)


def hit_prism(origin, directions, corners, height):
    """Return the distances along the rays to an upright prism over a convex, counter-clockwise foot; inf for a miss."""
    near, far = np.zeros(len(directions)), np.full(len(directions), np.inf)
    planes = [((b - a)[1], -(b - a)[0], 0.0, a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    normals = [(np.array(n[:3]), np.array([*n[3], 0.0])) for n in planes]
    normals += [(np.array([0, 0, 1.0]), np.array([0, 0, height])), (np.array([0, 0, -1.0]), np.zeros(3))]
    for normal, point in normals:
        speed, gap = directions @ normal, (origin - point) @ normal
        with np.errstate(divide="ignore", invalid="ignore"):
            t = -gap / speed
        near = np.where(speed < 0, np.maximum(near, t), near)
        far = np.where(speed > 0, np.minimum(far, t), far)
        far = np.where((speed == 0) & (gap > 0), -np.inf, far)
    return np.where(near <= far, near, np.inf)


def look(*shapes, noise=0.0, seed=0):
    """Return the cloud of the table and the shapes, each a (foot, height)."""
    directions = rays()
    distance = -CAMERA[2] / directions[:, 2]
    for corners, height in shapes:
        distance = np.minimum(distance, hit_prism(CAMERA, directions, np.asarray(corners), height))
    points = CAMERA + distance[:, None] * directions
    return points + np.random.default_rng(seed).normal(0, noise, points.shape) if noise else points


def cylinder(x, y, radius=0.03, height=0.15):
    turn = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    return np.array([x, y]) + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1), height


def box(x, y, half=0.03, height=0.15, yaw=0.3):
    c, s = np.cos(yaw), np.sin(yaw)
    corners = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) @ np.array([[c, s], [-s, c]])
    return corners + [x, y], height


def rotation(q):
    x, y, z, w = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def centre_of(grasp):
    """Return where the axis of a round thing must be for this grasp: before the palm, beside the root of the thumb."""
    r = rotation(grasp.pose.quaternion)
    return (grasp.pose.position + (grasp.width / 2 + 0.004) * r[:, 2] + 0.018 * r[:, 0])[:2]


@pytest.mark.parametrize("x", [0.42, 0.53, 0.64])
@pytest.mark.parametrize("y", [-0.08, 0.14, 0.32])
@pytest.mark.parametrize("noise", [0.0, 0.001])
def test_a_cylinder_is_found_to_3_mm_anywhere_in_the_pick_region(proposer, x, y, noise):
    (thing,) = [proposer.fit(c) for c in proposer.clusters(look(cylinder(x, y, 0.031, 0.16), noise=noise))]
    assert thing.is_round
    np.testing.assert_allclose(thing.centre, [x, y], atol=0.003)
    assert thing.half_width(np.array([1.0, 0.0])) == pytest.approx(0.031, abs=0.004)
    assert thing.top == pytest.approx(0.16, abs=0.003)


@pytest.mark.parametrize("yaw", [0.0, 0.3, 0.7, 1.2])
def test_a_box_is_told_from_a_cylinder_and_its_faces_are_found(proposer, yaw):
    (thing,) = [proposer.fit(c) for c in proposer.clusters(look(box(0.5, 0.1, 0.03, 0.15, yaw)))]
    assert not thing.is_round
    off = (thing.angle - yaw + np.pi / 4) % (np.pi / 2) - np.pi / 4
    assert abs(off) < 0.06
    assert thing.half_width(proposer.unit(yaw)) == pytest.approx(0.03, abs=0.004)


def test_grasps_follow_the_convention_of_the_grasp_frame(proposer):
    grasps = proposer.propose(look(cylinder(0.5, 0.1, 0.03, 0.16)))
    assert len(grasps) == 48
    for grasp in grasps:
        r = rotation(grasp.pose.quaternion)
        np.testing.assert_allclose(r @ r.T, np.eye(3), atol=1e-9)
        assert np.linalg.det(r) == pytest.approx(1)
        assert abs(r[2, 2]) < 1e-9, "the approach is horizontal"
        assert abs(r[2, 1]) == pytest.approx(1), "the fingers flex about the vertical"
        np.testing.assert_allclose(grasp.pre_grasp.position, grasp.pose.position - 0.12 * r[:, 2], atol=1e-9)
        np.testing.assert_allclose(grasp.post_grasp.position, grasp.pose.position + [0, 0, 0.20], atol=1e-9)
        assert grasp.pose.position[2] >= 0.075
        np.testing.assert_allclose(centre_of(grasp), [0.5, 0.1], atol=0.004)
        assert grasp.width == pytest.approx(0.06, abs=0.006)
    ups = {round(rotation(g.pose.quaternion)[2, 1]) for g in grasps}
    assert ups == {1, -1}
    assert [g.quality for g in grasps] == sorted((g.quality for g in grasps), reverse=True)


def test_the_best_grasp_comes_from_the_robots_side(proposer):
    best = proposer.propose(look(cylinder(0.5, 0.2)))[0]
    outward = np.array([0.5, 0.2]) / np.hypot(0.5, 0.2)
    assert rotation(best.pose.quaternion)[:2, 2] @ outward > 0.9


def test_the_best_grasp_of_a_box_faces_one_of_its_sides(proposer):
    best = proposer.propose(look(box(0.55, 0.1, yaw=0.2)))[0]
    z = rotation(best.pose.quaternion)[:2, 2]
    angle = np.arctan2(z[1], z[0]) - 0.2
    off = (angle + np.pi / 4) % (np.pi / 2) - np.pi / 4
    assert abs(off) < 0.1


def test_a_neighbour_in_the_way_changes_the_approach(proposer):
    behind = cylinder(0.42, 0.1)
    target = cylinder(0.58, 0.1)
    for grasp in proposer.propose(look(behind, target)):
        if np.linalg.norm(centre_of(grasp) - [0.58, 0.1]) > 0.02:
            continue
        z = rotation(grasp.pose.quaternion)[:2, 2]
        back = grasp.pose.position[:2] - np.linspace(0, 0.25, 30)[:, None] * z
        assert np.linalg.norm(back - [0.42, 0.1], axis=1).min() > 0.03 + 0.045


def test_three_things_at_the_least_distance_can_all_be_taken(proposer):
    places = [(0.5, 0.0), (0.5, 0.15), (0.62, 0.08)]
    grasps = proposer.propose(look(cylinder(*places[0]), box(*places[1]), cylinder(*places[2])))
    for place in places:
        mine = [g for g in grasps if np.linalg.norm(centre_of(g) - place) < 0.02]
        assert len(mine) >= 4, place


def test_an_empty_table_and_no_points_give_no_grasps(proposer):
    assert proposer.propose(look()) == []
    assert proposer.propose(np.zeros((0, 3))) == []
    assert proposer.propose(np.full((50, 3), np.nan)) == []


def test_what_is_outside_the_pick_region_too_low_or_too_wide_is_left_alone(proposer):
    assert proposer.propose(look(cylinder(0.5, -0.3))) == []
    assert proposer.propose(look(cylinder(0.5, 0.1, height=0.034))) == []
    assert proposer.propose(look(cylinder(0.5, 0.1, radius=0.07))) == []


def lying_cylinder(x, y, yaw, radius=0.031, length=0.155, step=0.002):
    """Return what a camera above sees of a lying cylinder: the upper half of it."""
    along, turn = np.meshgrid(np.arange(-length / 2, length / 2, step), np.arange(0, np.pi, step / radius))
    local = np.stack([along, radius * np.cos(turn), radius + radius * np.sin(turn)], axis=-1).reshape(-1, 3)
    c, s = np.cos(yaw), np.sin(yaw)
    return local @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + [x, y, 0]


def lying_box(x, y, yaw, half=0.03, length=0.15):
    """Return the foot and the height of a box that lies."""
    corners = np.array([[-length / 2, -half], [length / 2, -half], [length / 2, half], [-length / 2, half]])
    c, s = np.cos(yaw), np.sin(yaw)
    return corners @ np.array([[c, s], [-s, c]]) + [x, y], 2 * half


LYING = {
    "cylinder": lambda yaw: lying_cylinder(0.52, 0.1, yaw),
    "box": lambda yaw: look(lying_box(0.52, 0.1, yaw), noise=0.001),
}


@pytest.mark.parametrize("yaw", [0.0, 0.5, 1.2, 2.4])
@pytest.mark.parametrize("shape", LYING)
def test_a_lying_thing_is_pinched_from_above_across_its_shorter_side(proposer, shape, yaw):
    found = proposer.propose(LYING[shape](yaw))
    assert len(found) >= 2
    axis = np.array([np.cos(yaw), np.sin(yaw), 0.0])
    for grasp in found:
        r = rotation(grasp.pose.quaternion)
        assert abs(r[:, 1] @ axis) > np.cos(np.radians(8))  # the fingers flex about the thing's axis
        assert r[2, 2] < -0.8  # the palm looks down
        middle = grasp.pose.position + r @ proposer.MIDDLE
        off = middle - [0.52, 0.1, 0.031]
        assert np.linalg.norm(off - (off @ axis) * axis) < 0.012  # the thing is between the finger tips
        assert abs(off @ axis) < 0.04
        assert grasp.pose.position[2] >= proposer.REACH_DOWN - 1e-9
        assert grasp.width == pytest.approx(0.06, abs=0.012)
        back = grasp.pose.position - grasp.pre_grasp.position
        assert back == pytest.approx(proposer.APPROACH * r[:, 2])
        assert grasp.post_grasp.position - grasp.pose.position == pytest.approx([0, 0, proposer.LIFT])


def test_thumb_and_fingers_may_change_sides(proposer):
    found = proposer.propose(lying_cylinder(0.52, 0.1, 0.3))
    sides = {float(np.sign(rotation(g.pose.quaternion)[1, 0])) for g in found}
    assert sides == {-1.0, 1.0}


def test_a_low_thing_is_held_nearer_to_the_finger_tips_so_that_these_do_not_scratch_the_table(proposer):
    low = proposer.propose(look(lying_box(0.52, 0.1, 0.0, half=0.02)))
    assert low
    assert all(grasp.pose.position[2] == pytest.approx(proposer.REACH_DOWN) for grasp in low)


def test_what_stands_is_taken_before_what_lies(proposer):
    cloud = np.vstack([look(cylinder(0.42, 0.3)), lying_cylinder(0.56, 0.0, 0.0)])
    found = proposer.propose(cloud)
    downward = [rotation(g.pose.quaternion)[2, 2] < -0.8 for g in found]
    assert any(downward)
    assert downward == sorted(downward)


def test_a_lying_thing_beside_a_standing_one_is_not_reached_over_it(proposer):
    cloud = np.vstack([look(cylinder(0.52, 0.17)), lying_cylinder(0.52, 0.1, 0.0)])
    assert not any(rotation(g.pose.quaternion)[2, 2] < -0.8 for g in proposer.propose(cloud))


def test_it_knows_nothing_of_grip():
    text = PROPOSER.read_text()
    assert "import grip" not in text
    assert "from grip" not in text


# --- things that touch ---


def bar(x, y, yaw, length=0.15, width=0.06):
    """A lying thing: a long low box."""
    along, across = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
    corners = [s * length / 2 * along + t * width / 2 * across for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return np.array(corners) + [x, y], width


def middles(proposer, cloud):
    """Return how many things are seen, and where their middles are."""
    found = [part for c in proposer.clusters(cloud) for part in proposer.parts(c, 0.09, 30)]
    return sorted(thing.centre.round(2).tolist() for part in found if (thing := proposer.fit(part)) is not None)


@pytest.mark.parametrize("noise", [0.0, 0.001])
@pytest.mark.parametrize(
    ("shapes", "places"),
    [
        ([cylinder(0.50, 0.10), bar(0.50, 0.165, 0.0)], [[0.50, 0.10], [0.50, 0.17]]),  # lies along what stands
        ([box(0.50, 0.10, yaw=0.0), bar(0.61, 0.10, 0.0)], [[0.50, 0.10], [0.61, 0.10]]),  # lies head on
        ([bar(0.48, 0.10, 0.0), bar(0.586, 0.10, np.pi / 2)], [[0.48, 0.10], [0.59, 0.10]]),  # a T
        ([cylinder(0.50, 0.10), cylinder(0.556, 0.13)], [[0.50, 0.10], [0.56, 0.13]]),  # both stand
        ([bar(0.45, 0.10, 0.0), bar(0.56, 0.135, 0.9)], [[0.45, 0.10], [0.56, 0.14]]),  # at an angle
    ],
)
def test_things_that_touch_are_taken_apart(proposer, shapes, places, noise):
    assert len(proposer.clusters(look(*shapes, noise=noise))) == 1, "they touch"
    assert middles(proposer, look(*shapes, noise=noise)) == pytest.approx(np.array(places), abs=0.015)


@pytest.mark.parametrize("noise", [0.0, 0.001])
@pytest.mark.parametrize("yaw", np.linspace(0, np.pi, 7))
def test_one_thing_stays_one_thing(proposer, yaw, noise):
    for shape in (bar(0.5, 0.1, yaw), box(0.5, 0.1, yaw=yaw), cylinder(0.5, 0.1), bar(0.5, 0.3, yaw, 0.19, 0.07)):
        assert len(middles(proposer, look(shape, noise=noise))) == 1


def test_both_of_two_that_touch_get_grasps_where_the_hand_has_room(proposer):
    """A box of 6 cm and one that lies head on: the one is taken from the side, the other from above."""
    cloud = look(box(0.50, 0.10, yaw=0.0), bar(0.62, 0.10, 0.0, length=0.18))
    leaning = [rotation(grasp.pose.quaternion)[2, 2] < -0.5 for grasp in proposer.propose(cloud)]
    assert any(leaning)
    assert not all(leaning)


@pytest.mark.parametrize("yaw", [0.0, 0.4, 1.1])
@pytest.mark.parametrize("lower", [0.02, 0.04])
def test_two_that_share_a_face_but_not_a_height_are_two(proposer, yaw, lower):
    apart = 0.054 * proposer.unit(yaw)
    foot, height = box(0.5, 0.1, 0.027, 0.16, yaw)
    both = look((foot, height), (foot + apart, height - lower), noise=0.0007)
    (cluster,) = proposer.clusters(both)
    parts = proposer.parts(cluster, proposer.TABLE + proposer.PALM_HEIGHT, proposer.MIN_POINTS)
    things = sorted((proposer.fit(part) for part in parts), key=lambda thing: -thing.top)
    assert [thing.top for thing in things] == pytest.approx([height, height - lower], abs=0.004)
    for thing, middle in zip(things, ([0.5, 0.1], [0.5, 0.1] + apart), strict=True):
        np.testing.assert_allclose(thing.centre, middle, atol=0.012)


def upright(kind, x, y, size, height, yaw):
    return box(x, y, size, height, yaw) if kind == "box" else cylinder(x, y, size, height)


@pytest.mark.parametrize("noise", [0.0, 0.001, 0.0015])
@pytest.mark.parametrize("yaw", [0.0, 0.5, 1.2, 2.0])
@pytest.mark.parametrize("kinds", [("box", "cylinder"), ("cylinder", "cylinder"), ("cylinder", "box")])
def test_two_of_one_height_that_stand_side_by_side_are_two(proposer, kinds, yaw, noise):
    """A round thing touches the other along a line, so their tops have a waist between them."""
    sizes, middle = (0.030, 0.033), np.array([0.5, 0.1])
    beside = middle + sum(sizes) * proposer.unit(yaw)
    shapes = [upright(k, *at, size, 0.15, yaw) for k, at, size in zip(kinds, (middle, beside), sizes, strict=True)]
    (cluster,) = proposer.clusters(look(*shapes, noise=noise))
    parts = proposer.parts(cluster, proposer.TABLE + proposer.PALM_HEIGHT, proposer.MIN_POINTS)
    assert len(parts) == 2
    things = sorted((proposer.fit(part) for part in parts), key=lambda t: np.linalg.norm(t.centre - middle))
    for thing, at, size in zip(things, (middle, beside), sizes, strict=True):
        np.testing.assert_allclose(thing.centre, at, atol=0.006)
        assert thing.half_width(proposer.unit(yaw + np.pi / 2)) == pytest.approx(size, abs=0.008)


def test_three_in_a_row_are_three(proposer):
    places = [[0.44, 0.1], [0.50, 0.1], [0.56, 0.1]]
    assert middles(proposer, look(*(cylinder(*at) for at in places))) == pytest.approx(np.array(places), abs=0.006)


@pytest.mark.parametrize("noise", [0.0, 0.0015])
@pytest.mark.parametrize("yaw", np.linspace(0, np.pi / 2, 8))
def test_the_top_of_one_thing_has_no_waist(proposer, yaw, noise):
    for seed, (x, y) in enumerate([(0.42, -0.06), (0.53, 0.14), (0.62, 0.32)]):
        for shape in (box(x, y, 0.034, 0.17, yaw), box(x, y, 0.028, 0.14, yaw), cylinder(x, y, 0.03, 0.15)):
            (cluster,) = proposer.clusters(look(shape, noise=noise, seed=seed))
            assert len(proposer.parts(cluster, 0.09, 30)) == 1


def test_a_handle_stays_with_its_cup(proposer):
    cup, handle = (
        cylinder(0.5, 0.1, 0.034),
        (np.array([[0.53, 0.094], [0.56, 0.094], [0.56, 0.106], [0.53, 0.106]]), 0.15),
    )
    (cluster,) = proposer.clusters(look(cup, handle))
    assert len(sys.modules["splitting"].by_waist(cluster, 0.09, 30)) == 1
