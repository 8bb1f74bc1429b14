import numpy as np
import pinocchio as pin
import pytest
from table_top import AT_TABLES, named, place_things, robot_model, room

from grip_bt.base.values import JointState, Pose
from grip_bt.commanders.description.packages import Packages
from grip_bt.commanders.kinematics.collision import CollisionChecker
from grip_bt.commanders.kinematics.shapes import simplified


def random_configurations(chain, count, seed=0):
    return np.random.default_rng(seed).uniform(chain.limits.lower, chain.limits.upper, (count, len(chain.joints)))


@pytest.mark.parametrize("name", AT_TABLES)
def test_a_chain_moves_the_grasp_frame_as_the_whole_robot_does(name):
    model = robot_model(name)
    chain = model.chain("arm")
    for q in random_configurations(chain, 20):
        whole = model.grasp_pose(JointState(chain.joints, q))
        assert chain.grasp_pose(q).homogeneous == pytest.approx(whole.matrix(), abs=1e-9)


@pytest.mark.parametrize("name", AT_TABLES)
def test_home_is_free_and_its_neighbours_in_the_hand_do_not_count(name):
    model = robot_model(name)
    home = named(model, "arm", "home").position
    for posture in model.description.named_states["hand"].values():
        checker = CollisionChecker(model.chain("arm", posture), room(model).snapshot(), "right_hand")
        assert checker.pairs(home) == ()


def test_simplified_shapes_find_every_collision_that_the_originals_find():
    """The meshes of a UR5 against their hulls, and the capsules of a Panda against the shapes that they replace."""
    for urdf in ("ur_description/urdf/ur5_robot.urdf", "panda_description/urdf/panda_collision.urdf"):
        assets = Packages().find("example-robot-data")
        text = (assets / "robots" / urdf).read_text().replace("package://example-robot-data", str(assets))
        model = pin.buildModelFromXML(text)
        raw, simple = (pin.buildGeomFromUrdfString(model, text, pin.GeometryType.COLLISION) for _ in range(2))
        shapes = simplified(simple.geometryObjects)
        assert len(shapes) <= raw.ngeoms
        simple = pin.GeometryModel()
        for shape in shapes:
            simple.addGeometryObject(shape)
        rng = np.random.default_rng(0)
        missed = found = extra = 0
        for _ in range(150):
            q = rng.uniform(np.maximum(model.lowerPositionLimit, -3), np.minimum(model.upperPositionLimit, 3))
            original, cheap = _touching_bodies(model, raw, q), _touching_bodies(model, simple, q)
            # Neighbours touch flush at their joint, where hulls and triangles may differ by rounding.
            missed += len({(a, b) for a, b in original - cheap if not _neighbours(model, a, b)})
            extra += len(cheap - original)
            found += len(original)
        assert missed == 0
        assert found > 0
        if "panda" in urdf:
            assert extra == 0, "a capsule is exactly the union of its parts"


def _neighbours(model, one, other):
    a, b = (model.frames[k].parentJoint for k in (one, other))
    return model.parents[a] == b or model.parents[b] == a


def _touching_bodies(model, geometry, q):
    if not len(geometry.collisionPairs):
        geometry.addAllCollisionPairs()
    data, results = model.createData(), geometry.createData()
    pin.computeCollisions(model, data, geometry, results, q, False)
    shapes = geometry.geometryObjects
    pairs = zip(geometry.collisionPairs, results.collisionResults, strict=True)
    return {
        tuple(sorted((shapes[p.first].parentFrame, shapes[p.second].parentFrame)))
        for p, result in pairs
        if result.isCollision() and shapes[p.first].parentFrame != shapes[p.second].parentFrame
    }


def test_a_folded_arm_collides_with_itself_and_the_pair_is_named(model):
    chain = model.chain("arm")
    checker = CollisionChecker(chain, room(model).snapshot().without(room(model).names()))
    configurations = random_configurations(chain, 2000)
    colliding = configurations[~checker.free_each(configurations)]
    assert 0 < len(colliding) < 1000
    links = set(model.model.frames[k].name for k in range(model.model.nframes))
    for q in colliding[:50]:
        assert checker.pairs(q)
        assert all(a in links and b in links for a, b in checker.pairs(q))


def test_batched_checks_agree_with_single_ones(model):
    scene = room(model)
    place_things(scene, np.random.default_rng(1))
    checker = CollisionChecker(model.chain("arm"), scene.snapshot(), "right_hand")
    configurations = random_configurations(checker.chain, 500)
    together = checker.free_each(configurations)
    assert 50 < together.sum() < 450
    assert [checker.free(q) for q in configurations] == list(together)
    assert [not checker.pairs(q) for q in configurations] == list(together)
    assert not checker.all_free(configurations)
    assert checker.all_free(configurations[together])


def test_a_box_around_the_hand_is_touched_by_the_hand_only(model):
    scene = room(model)
    home = named(model, "arm", "home")
    grasp = model.grasp_pose(home)
    scene.set_box("thing", (0.03, 0.12, 0.03), Pose(grasp.apply([[0.0, 0.0, 0.012]])[0], grasp.quaternion))
    checker = CollisionChecker(model.chain("arm"), scene.snapshot(), "right_hand")
    pairs = checker.pairs(home.position)
    assert pairs
    assert all(b == "thing" and a in model.description.hand_links for a, b in pairs)


def test_what_is_held_moves_along_may_touch_the_hand_and_collides_with_the_room(model):
    scene = room(model)
    home = named(model, "arm", "home")
    grasp = model.grasp_pose(home)
    scene.set_box("thing", (0.06, 0.5, 0.06), Pose(grasp.apply([[0.0, 0.0, 0.035]])[0], grasp.quaternion))
    held = scene.snapshot().attaching("thing", "right_hand", grasp)
    free = CollisionChecker(model.chain("arm"), held, "right_hand")
    assert free.pairs(home.position) == ()
    ceiling = grasp.position + [0.0, 0.0, 0.3]
    scene.set_box("lamp", (0.3, 0.3, 0.2), Pose(ceiling))
    held = scene.snapshot().attaching("thing", "right_hand", grasp)
    assert CollisionChecker(model.chain("arm"), held, "right_hand").pairs(home.position) == (("thing", "lamp"),)


def test_an_allowed_pair_is_not_reported(model):
    scene = room(model)
    home = named(model, "arm", "home")
    grasp = model.grasp_pose(home)
    scene.set_box("thing", (0.03, 0.03, 0.03), Pose(grasp.apply([[0.0, 0.0, 0.01]])[0], grasp.quaternion))
    for link in model.description.hand_links:
        scene.allow("thing", link)
    checker = CollisionChecker(model.chain("arm"), scene.snapshot(), "right_hand")
    assert checker.pairs(home.position) == ()


def test_a_margin_keeps_the_distance_that_it_names(model):
    scene = room(model)
    home = named(model, "arm", "home").position
    chain = model.chain("arm")
    data = chain.geometry.createData()
    pin.updateGeometryPlacements(chain.model, chain.data, chain.geometry, data, home)
    lowest = min((data.oMg[k].translation[2], k) for k in chain.hand)[0]
    scene.set_box("plate", (0.8, 0.8, 0.02), Pose([0.5, -0.3, lowest - 0.15]))
    assert CollisionChecker(chain, scene.snapshot(), "right_hand", 0.0).free(home)
    assert not CollisionChecker(chain, scene.snapshot(), "right_hand", 0.15).free(home)


def test_positions_that_are_not_finite_are_refused(model):
    with pytest.raises(ValueError, match="panda_joint1.*nan"):
        model.grasp_pose(JointState(("panda_joint1",), [np.nan]))
