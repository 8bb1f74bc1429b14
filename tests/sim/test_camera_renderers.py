"""What the renderers draw, against rays cast into the same shapes; SAPIEN's is tried where Vulkan works."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from ray_camera import RayCamera
from scipy.spatial import ConvexHull

from grip_sim.cameras import Places, vulkan_works
from grip_sim.cameras.looks import Target, visuals_of
from grip_sim.cameras.mesh_files import read_mesh
from grip_sim.cameras.raster import RasterRenderer
from grip_sim.physics import make_scene, physx, sapien
from grip_sim.specs import CameraSpec, WorldSpec
from grip_sim.worlds import load_world

pytestmark = pytest.mark.sim
CAMERA = CameraSpec("c", 80, 60, 0.9, (0.0, 0.0, 0.0), (0.5, -0.5, 0.5, -0.5), far=5.0, shapes="collision")
"""At the origin, looking along x."""
SHAPES = ("box", "sphere", "capsule", "cylinder", "mesh", "open")
TENTH_OF_A_MICRON = 1e-7


def body(scene, kind, place, rng, folder):
    """Return something of 0.1 to 0.5 m; round things only where tolerance is given for their corners."""
    builder = scene.create_actor_builder()
    a, b, c = rng.uniform(0.05, 0.25, 3)
    if kind == "box":
        builder.add_box_collision(half_size=[a, b, c])
    elif kind == "sphere":
        builder.add_sphere_collision(radius=a)
    elif kind == "capsule":
        builder.add_capsule_collision(radius=a, half_length=b)
    elif kind == "cylinder":
        builder.add_cylinder_collision(radius=a, half_length=b)
    else:
        file = folder / f"{kind}_{rng.integers(1 << 40)}.obj"
        points = rng.normal(size=(14, 3)) * 0.15
        lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in points]
        if kind == "open":  # a jagged body that isn't convex: triangles of a ball with a wavy surface
            lines = wavy(rng)
        else:
            lines += ["f {} {} {}".format(*(t + 1)) for t in ConvexHull(points).simplices]
        file.write_text("\n".join(lines))
        if kind == "open":
            builder.add_nonconvex_collision_from_file(str(file))
        else:
            builder.add_convex_collision_from_file(str(file))
    builder.set_physx_body_type("static")
    builder.set_initial_pose(place)
    return builder.build(name=kind).find_component_by_type(physx.PhysxRigidStaticComponent)


def wavy(rng):
    v, u = np.meshgrid(np.linspace(0.2, np.pi - 0.2, 7), np.linspace(0, 2 * np.pi, 12, endpoint=False), indexing="ij")
    ball = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], -1).reshape(-1, 3)
    ball *= rng.uniform(0.12, 0.28, (len(ball), 1))
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in ball]
    for i in range(6):
        for j in range(12):
            p, q, r, s = (1 + 12 * (i + di) + (j + dj) % 12 for di, dj in ((0, 0), (0, 1), (1, 0), (1, 1)))
            lines += [f"f {p} {r} {q}", f"f {q} {r} {s}"]
    return lines


def scene_of(seed, kinds, folder):
    """Return physics with bodies before, beside and partly behind the camera, none of them around it."""
    rng, scene = np.random.default_rng(seed), make_scene(1 / 240)
    targets = []
    for i, kind in enumerate(kinds):
        while True:
            place = rng.uniform((-0.4, -0.8, -0.6), (2.5, 0.8, 0.6))
            if np.linalg.norm(place[1:]) > 0.55 or place[0] > 0.9:
                break
        turn = rng.normal(size=4)
        made = body(scene, kind, sapien.Pose(place, turn / np.linalg.norm(turn)), rng, folder)
        targets.append(Target(made, f"{kind}_{i}", (50 + 40 * i, 200 - 30 * i, 120)))
    scene.step()
    return scene, targets


def places_of(targets):
    return Places.of([[*t.body.entity_pose.p, *t.body.entity_pose.q] for t in targets])


def both(scene, targets, spec=CAMERA):
    made = RasterRenderer(spec.info(), spec.far, targets, visual=False).draw(spec.info().pose, places_of(targets))
    return made, RayCamera(spec, scene.physx_system, (), targets).capture()


def inner(frame, *others):
    """Return the pixels whose neighbours show the same surface of all frames: no edge runs through them."""
    good = np.ones(frame.depth.shape, bool)
    for each in (frame, *others):
        steps = [cv2.dilate(n, np.ones((3, 3))) - cv2.erode(n, np.ones((3, 3))) for n in cv2.split(each.normals)]
        good &= (np.max(steps, axis=0) < 1e-3) & (
            cv2.morphologyEx(each.labels, cv2.MORPH_GRADIENT, np.ones((3, 3))) == 0
        )
    return good


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), kinds=st.lists(st.sampled_from(("box", "mesh", "open")), min_size=1, max_size=6))
def test_flat_bodies_are_seen_as_rays_see_them(seed, kinds, tmp_path_factory):
    scene, targets = scene_of(seed, kinds, tmp_path_factory.mktemp("meshes"))
    drawn, cast = both(scene, targets)
    assert (drawn.labels == cast.labels).mean() > 0.995  # at edges, either may be right
    sure = inner(drawn, cast) & (drawn.labels >= 0)
    hulls = np.isin(drawn.labels, [i for i, kind in enumerate(kinds) if kind == "mesh"])
    off = np.abs(drawn.depth - cast.depth)
    assert off[sure & ~hulls].max(initial=0) < 5e-6  # rays are rounded where they begin and where they end
    assert off[sure & hulls].max(initial=0) < 1e-3  # PhysX's rays meet a hull's faces, which are triangles put together
    assert np.abs(drawn.normals - cast.normals)[sure & ~hulls].max(initial=0) < 1e-5
    assert (drawn.depth[drawn.labels < 0] == 0).all()
    assert (drawn.depth[drawn.labels >= 0] > 0).all()


def depth_of_boxes(targets):
    """Return the depth of each pixel in double precision (Kay and Kajiya's slabs), infinity where nothing is."""
    rays, found = CAMERA.info().rays() @ CAMERA.info().pose.rotation().T, np.inf
    for target, rotation, position in zip(targets, *places_of(targets), strict=True):
        half = target.body.collision_shapes[0].half_size.astype(float)
        with np.errstate(divide="ignore"):
            one, two = ((side * half + rotation.T @ position) / (rays @ rotation) for side in (-1, 1))
        enter, leave = np.minimum(one, two).max(axis=2), np.maximum(one, two).min(axis=2)
        found = np.minimum(found, np.where((enter <= leave) & (enter > 0), enter, np.inf))
    return found


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_depth_is_exact_to_a_ten_thousandth_of_a_millimetre(seed, tmp_path_factory):
    _, targets = scene_of(seed, ("box",) * 4, tmp_path_factory.mktemp("meshes"))
    pose = CAMERA.info().pose
    drawn = RasterRenderer(CAMERA.info(), CAMERA.far, targets, visual=False).draw(pose, places_of(targets))
    true = depth_of_boxes(targets)
    seen = (drawn.labels >= 0) & (true < CAMERA.far)
    assert ((drawn.labels >= 0) == (true < CAMERA.far)).mean() > 0.999
    off = np.abs(drawn.depth - true)[seen & inner(drawn)]
    assert (off <= np.maximum(TENTH_OF_A_MICRON, np.spacing(drawn.depth)[seen & inner(drawn)] / 2 * 1.001)).all()


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), kind=st.sampled_from(("sphere", "capsule", "cylinder")))
def test_round_bodies_are_seen_up_to_the_corners_that_circles_get(seed, kind, tmp_path_factory):
    scene, targets = scene_of(seed, (kind,) * 3, tmp_path_factory.mktemp("meshes"))
    drawn, cast = both(scene, targets)
    assert (drawn.labels == cast.labels).mean() > 0.98
    facing = -(drawn.normals * CAMERA.info().rays()).sum(axis=2) > 0.3
    sure = (drawn.labels == cast.labels) & (drawn.labels >= 0) & facing & inner_labels(drawn)
    assert np.abs(drawn.depth - cast.depth)[sure].max(initial=0) < 0.25 * (1 - np.cos(np.pi / 48)) * 2 / 0.3 + 1e-5


def inner_labels(frame):
    return cv2.morphologyEx(frame.labels, cv2.MORPH_GRADIENT, np.ones((3, 3))) == 0


def test_what_reaches_behind_the_camera_is_cut_off_and_what_is_behind_it_is_not_seen(tmp_path):
    rng, scene = np.random.default_rng(0), make_scene(1 / 240)
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[4.0, 3.0, 0.1])  # a floor from behind the camera to before it
    builder.set_physx_body_type("static")
    builder.set_initial_pose(sapien.Pose([0.0, 0.0, -0.3]))
    floor = builder.build(name="floor").find_component_by_type(physx.PhysxRigidStaticComponent)
    behind = body(scene, "box", sapien.Pose([-0.5, 0.0, 0.0]), rng, tmp_path)
    targets = [Target(floor, "floor", (1, 2, 3)), Target(behind, "behind", (4, 5, 6))]
    scene.step()
    drawn, cast = both(scene, targets)
    assert np.array_equal(drawn.labels, cast.labels)
    assert set(np.unique(drawn.labels)) == {-1, 0}
    assert np.abs(drawn.depth - cast.depth).max() < 2e-6


def test_no_depth_is_nearer_than_the_near_plane_nor_farther_than_the_far_one(tmp_path):
    rng, scene = np.random.default_rng(1), make_scene(1 / 240)
    close = body(scene, "box", sapien.Pose([0.0, 0.35, 0.0]), rng, tmp_path)
    beyond = body(scene, "box", sapien.Pose([5.5, 0.0, 0.0]), rng, tmp_path)
    targets = [Target(close, "close", (1, 2, 3)), Target(beyond, "beyond", (4, 5, 6))]
    scene.step()
    drawn, _ = both(scene, targets)
    assert 1 not in drawn.labels
    seen = drawn.depth[drawn.labels >= 0]
    assert seen.size == 0 or (0.0099 <= seen.min() and seen.max() <= 5.0)


def test_a_frame_is_the_same_bit_by_bit_whatever_the_threads():
    from grip_sim.world import World

    frames = []
    threads = cv2.getNumThreads()
    try:
        for count in (1, 2, 4):
            cv2.setNumThreads(count)
            frames.append(
                World(replace(load_world("table", 3), cameras=(CameraSpec(renderer="raster"),))).cameras.look(
                    "overhead"
                )
            )
    finally:
        cv2.setNumThreads(threads)
    for other in frames[1:]:
        assert np.array_equal(frames[0].image, other.image)
        assert np.array_equal(frames[0].depth, other.depth)


def textured(folder):
    """Write a square of 1 m, of which each quarter has a colour of its own, in the plane x = 0, seen from -x."""
    picture = np.zeros((64, 64, 3), np.uint8)
    picture[:32, :32], picture[:32, 32:], picture[32:, :32], picture[32:, 32:] = (
        (0, 0, 250), (0, 250, 0), (250, 0, 0), (250, 250, 250),
    )  # fmt: skip
    cv2.imwrite(str(folder / "quarters.png"), picture)  # blue, green, red: above left it is red
    (folder / "square.mtl").write_text("newmtl paint\nKd 1 1 1\nmap_Kd quarters.png\n")
    (folder / "square.obj").write_text(
        "mtllib square.mtl\nv 0 0.5 -0.5\nv 0 -0.5 -0.5\nv 0 -0.5 0.5\nv 0 0.5 0.5\n"
        "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl paint\nf 1/1 2/2 3/3 4/4\n"
    )
    return folder / "square.obj"


def square(folder):
    scene = make_scene(1 / 240)
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.01, 0.5, 0.5])
    builder.set_physx_body_type("static")
    builder.set_initial_pose(sapien.Pose([1.5, 0, 0]))
    made = builder.build(name="square").find_component_by_type(physx.PhysxRigidStaticComponent)
    scene.step()
    return scene, [Target(made, "square", (9, 9, 9), lambda: read_mesh(textured(folder)))]


def test_a_picture_on_a_mesh_is_the_right_way_up(tmp_path):
    _, targets = square(tmp_path)
    drawn = RasterRenderer(CAMERA.info(), 5.0, targets).draw(CAMERA.info().pose, places_of(targets))
    above, below = drawn.image[20], drawn.image[40]
    assert [int(np.argmax(above[c])) for c in (32, 48)] == [0, 1]  # red, green
    assert int(np.argmax(below[32])) == 2  # blue
    assert np.ptp(below[48].astype(int)) == 0  # white
    assert drawn.depth[30, 40] == pytest.approx(1.5, abs=1e-6)


def test_the_visuals_of_a_robot_are_read_with_their_colours():
    from grip_bt.commanders.description.load import load_robot

    visuals = visuals_of(load_robot("panda_allegro").urdf)
    assert len(visuals) > 20
    looks = visuals["panda_link6"]()
    assert {(255, 255, 255), (64, 64, 64)} <= {look.colour for look in looks}
    assert sum(len(look.triangles) for look in looks) > 1000


@pytest.mark.parametrize("ending", ["stl", "ply", "obj", "glb"])
def test_triangles_share_their_corners_though_a_file_has_them_for_each(tmp_path, ending):
    box = trimesh.creation.box([0.1, 0.2, 0.3])
    box.unmerge_vertices()
    box.export(tmp_path / f"box.{ending}")
    (look,) = read_mesh(tmp_path / f"box.{ending}")
    assert (len(look.points), len(look.triangles)) == (8, 12)
    assert np.ptp(look.points, axis=0) == pytest.approx([0.1, 0.2, 0.3])


@pytest.mark.parametrize(
    ("face", "how"), [("f 1 2 3", "points"), ("f -3 -2 -1", "from the end"), ("f 1//1 2//1 3//1", "normals")]
)
def test_faces_of_obj_files_are_read_however_they_are_written(tmp_path, face, how):
    (tmp_path / "a.obj").write_text(f"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\n{face}\n")
    (look,) = read_mesh(tmp_path / "a.obj")
    assert look.triangles.tolist() == [[0, 1, 2]], how
    assert look.colour is None


def test_a_mirrored_mesh_is_turned_right_side_out(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (look,) = read_mesh(tmp_path / "a.obj")
    corners = (mirrored := look.moved(np.eye(4), np.array([-1.0, 1, 1]))).points[mirrored.triangles[0]]
    assert np.cross(corners[1] - corners[0], corners[2] - corners[0])[2] > 0


def test_what_has_no_readable_mesh_is_drawn_by_its_collision_shapes(tmp_path, caplog):
    rng, scene = np.random.default_rng(0), make_scene(1 / 240)
    made = body(scene, "box", sapien.Pose([1.0, 0, 0]), rng, tmp_path)
    target = Target(made, "box", (9, 9, 9), lambda: read_mesh(tmp_path / "gone.stl"))
    assert sum(len(look.triangles) for look in target.looks()) == 12
    assert "collision shapes" in caplog.text


@pytest.mark.skipif(not vulkan_works(), reason="Vulkan doesn't work here")
def test_sapien_s_renderer_sees_the_same():
    from grip_sim.world import World

    view = CameraSpec("view", 160, 120, 0.9, (1.2, 0.5, 0.6), target=(0.5, 0.0, 0.1), renderer="raster")
    cameras = (view, replace(view, name="vulkan", renderer="sapien"))
    world = World(WorldSpec(objects=load_world("table", 0).objects, cameras=cameras))
    drawn, seen = world.cameras.look("view"), world.cameras.look("vulkan")
    assert (drawn.labels == seen.labels).mean() > 0.999
    same = (drawn.labels == seen.labels) & (drawn.labels >= 0)
    assert np.quantile(np.abs(drawn.depth - seen.depth)[same], 0.99) < 1e-5
    assert np.abs(drawn.normals - seen.normals)[same].mean() < 1e-3
    assert np.abs(drawn.image.astype(int) - seen.image)[same].mean() < 20
    again = world.cameras.look("vulkan")
    assert np.array_equal(again.depth, seen.depth)
    assert np.array_equal(again.image, seen.image)
