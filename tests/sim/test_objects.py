"""Objects: the library's files, what worlds make of them, and other people's meshes brought in."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
import trimesh

from grip_bt.base.errors import DocumentError, GripError
from grip_sim.objects import BUILTIN, load_object, object_file
from grip_sim.objects.adding import check_mesh, find_object, write_object
from grip_sim.specs import ObjectSpec, WorldSpec
from grip_sim.worlds import load_world

MESH = "<geometry><mesh><uri>b.obj</uri></mesh></geometry>"


def quiet(text: str) -> None:
    """Tell nobody."""


def added(path: Path, folder: Path, name: str = "thing", scale: float | None = None, parts: int = 8):
    found = find_object(path)
    checked = check_mesh(found, scale, parts, quiet)
    file = write_object(name, found, checked, folder, mass=None, friction=None, source="made here")
    return load_object(file), checked


def cup() -> trimesh.Trimesh:
    """Return an open cup of 6 cm, closed as a surface."""
    outline = [(0, 0), (0.03, 0), (0.03, 0.08), (0.027, 0.08), (0.027, 0.004), (0, 0.004)]
    return trimesh.creation.revolve(outline, sections=24)


def test_the_library_holds_many_things_of_a_size_and_weight_that_hands_hold():
    assert len(BUILTIN) >= 25
    for name in BUILTIN:
        model = load_object(object_file(name))
        assert model.doc, name
        assert 0.005 < min(model.size) <= max(model.size) < 0.3, name
        assert 0.005 < model.mass < 0.6, name


@pytest.mark.parametrize("name", BUILTIN)
def test_mass_properties_are_those_of_a_body(name):
    model = load_object(object_file(name))
    moments = np.linalg.eigvalsh(model.inertia)
    assert moments[0] > 0
    assert moments[2] <= moments[0] + moments[1]  # the triangle inequality of moments of inertia
    low, high = (getattr(np.concatenate(model.parts), end)(axis=0) for end in ("min", "max"))
    assert np.all(low < model.centre)
    assert np.all(model.centre < high)
    assert low + high == pytest.approx(0, abs=1e-9)
    for part in model.parts:
        assert trimesh.convex.convex_hull(part).volume > 0


def test_a_tin_has_the_inertia_of_a_cylinder():
    model = load_object(object_file("tin"))
    r, h, m = 0.034, 0.102, model.mass
    across, along = m * (3 * r * r + h * h) / 12, m * r * r / 2
    assert np.diag(model.inertia) == pytest.approx([across, across, along], rel=0.025)  # a prism of 24 sides


def test_a_mug_is_hollow_and_has_a_handle():
    mug = load_object(object_file("mug"))
    inside = [0.0 - 0.0135, 0.0, 0.02]  # the middle of the cup, which the handle puts off the middle of the box
    hulls = [trimesh.convex.convex_hull(part) for part in mug.parts]
    assert not any(hull.contains([inside])[0] for hull in hulls)
    assert mug.size[0] > mug.size[1] + 0.02


def test_a_world_draws_models_as_it_draws_shapes(tmp_path):
    file = tmp_path / "worlds" / "mine.yaml"
    file.parent.mkdir()
    file.write_text(
        "grip: 1\nregions: {here: {size: [0.5, 0.5, 0.2], at: [0.5, 0, 0]}}\nobjects:\n"
        "  things: {draw: 3, of: [{model: mug}, {model: tin, scale: [0.5, 0.9], mass: 0.1, friction: 0.2}], in: here}\n"
        "  own: {model: thing, at: [0.9, 0, 0]}\n"
    )
    (tmp_path / "objects").mkdir()
    (tmp_path / "objects" / "thing.yaml").write_text("grip: 1\nmass: 0.1\nsolids: [{box: [0.02, 0.02, 0.05]}]\n")
    first, again = (load_world("mine", 4, tmp_path) for _ in range(2))
    assert first == again
    assert WorldSpec.from_json(first.to_json()) == first
    own, *drawn = first.objects
    assert own.position == pytest.approx((0.9, 0, 0.025))
    assert {thing.name.rsplit("_", 1)[0] for thing in drawn} <= {"mug", "tin"}
    for thing in drawn:
        model = load_object(Path(thing.model))
        assert thing.height == pytest.approx(model.size[2] * thing.scale)
        assert (thing.mass, thing.friction) == ((0.28, 0.45) if model.name == "mug" else (0.1, 0.2))
    file.write_text(file.read_text().replace("model: mug", "model: mag"))
    with pytest.raises(GripError, match="unknown object 'mag'; did you mean 'mug'"):
        load_world("mine", 0, tmp_path)


def test_a_mesh_that_was_written_again_is_read_again(tmp_path):
    file = tmp_path / "thing.yaml"
    file.write_text("grip: 1\nmass: 0.1\nmesh: thing.stl\n")
    for number, height in enumerate((0.06, 0.09)):
        trimesh.creation.box((0.04, 0.05, height)).export(tmp_path / "thing.stl")
        os.utime(tmp_path / "thing.stl", ns=(number + 1, number + 1))
        assert load_object(file).size[2] == pytest.approx(height)


@pytest.mark.sim
@pytest.mark.parametrize("name", BUILTIN)
def test_each_comes_to_rest_on_a_table(name):
    from grip_sim.world import World

    file = object_file(name)
    model = load_object(file)
    r, height, weight = model.radius, model.size[2], model.mass
    thing = ObjectSpec(
        "it", "model", r, height, (0.6, 0, height / 2 + 0.01), mass=weight, friction=0.5, model=str(file)
    )
    world = World(WorldSpec(objects=(thing,), cameras=()))
    for _ in range(720):
        world.step()
    before, deepest = world.object_pose("it"), 0.0
    for _ in range(240):
        world.step()
        deepest = min([deepest, *(point.separation for c in world.scene.get_contacts() for point in c.points)])
    assert before.position[2] > 0
    rolls = name in ("ball", "tennis_ball", "apple", "egg", "pen", "can", "screwdriver", "pipette", "tube", "banana")
    assert np.linalg.norm(np.subtract(world.object_pose("it").position, before.position)) < (0.05 if rolls else 5e-4)
    assert deepest > -5e-4


@pytest.mark.sim
def test_physics_has_the_mass_and_the_inertia_of_the_file():
    from grip_sim.physics import add_model, make_scene

    file = object_file("mug")
    model = load_object(file)
    thing = ObjectSpec("mug", "model", 0.1, 0.1, (0, 0, 1), mass=2 * model.mass, model=str(file), scale=1.5)
    body = add_model(make_scene(1 / 240), thing, model)
    assert body.mass == pytest.approx(2 * model.mass)
    assert sorted(body.inertia) == pytest.approx(sorted(np.linalg.eigvalsh(model.inertia) * 2 * 1.5**2), rel=1e-4)
    assert body.cmass_local_pose.p == pytest.approx(model.centre * 1.5, abs=1e-6)
    axes = body.cmass_local_pose.to_transformation_matrix()[:3, :3].astype(float)
    assert axes @ np.diag(body.inertia) @ axes.T == pytest.approx(model.inertia * 2 * 1.5**2, abs=1e-7)


def test_a_mesh_in_millimetres_is_taken_as_such_and_said(tmp_path):
    mesh = cup()
    mesh.apply_scale(1000)
    mesh.export(tmp_path / "cup.stl")
    model, checked = added(tmp_path / "cup.stl", tmp_path / "objects")
    assert model.size == pytest.approx((0.06, 0.06, 0.08), abs=2e-3)
    assert any("0.001" in remark for remark in checked.remarks)
    assert model.mass == pytest.approx(400 * cup().volume, rel=0.01)
    assert 1 < len(model.parts) <= 8
    hulls = [trimesh.convex.convex_hull(part) for part in model.parts]
    assert not any(hull.contains([[0, 0, 0.02]])[0] for hull in hulls)  # it stays hollow
    with pytest.raises(GripError, match="is there already"):
        added(tmp_path / "cup.stl", tmp_path / "objects")


def test_a_convex_mesh_is_one_part(tmp_path):
    trimesh.creation.cylinder(0.03, 0.1).export(tmp_path / "can.ply")
    model, checked = added(tmp_path / "can.ply", tmp_path / "objects")
    assert (len(model.parts), checked.remarks) == (1, ("it is convex",))


def test_urdf_and_sdf_say_scale_mass_and_friction(tmp_path):
    (tmp_path / "meshes").mkdir()
    trimesh.creation.box((40, 50, 60)).export(tmp_path / "meshes" / "box.obj")
    (tmp_path / "a.urdf").write_text(
        '<robot name="a"><link name="a"><inertial><mass value="0.3"/></inertial><visual><geometry>'
        '<mesh filename="package://a/meshes/box.obj" scale="0.001 0.001 0.001"/></geometry></visual></link></robot>'
    )
    (tmp_path / "a.sdf").write_text(
        '<sdf version="1.6"><model name="a"><link name="a"><inertial><mass>0.4</mass></inertial><collision name="c">'
        "<geometry><mesh><scale>0.001 0.001 0.001</scale><uri>model://a/meshes/box.obj</uri></mesh></geometry><surface>"
        "<friction><ode><mu>0.7</mu></ode></friction></surface></collision></link></model></sdf>"
    )
    urdf, _ = added(tmp_path / "a.urdf", tmp_path / "objects", "one")
    sdf, _ = added(tmp_path / "a.sdf", tmp_path / "objects", "two")
    assert urdf.size == sdf.size == pytest.approx((0.04, 0.05, 0.06))
    assert (urdf.mass, sdf.mass, sdf.friction) == (0.3, 0.4, 0.7)


@pytest.mark.parametrize("folder", ["google_16k", "meshes"])
def test_a_folder_is_looked_through_and_its_pictures_come_along(tmp_path, folder):
    home = tmp_path / "003_box"
    (home / folder).mkdir(parents=True)
    mesh = home / folder / ("textured.obj" if folder == "google_16k" else "model.obj")
    picture = "texture_map.png" if folder == "google_16k" else "texture.png"
    beside = home / folder if folder == "google_16k" else home / "materials" / "textures"
    beside.mkdir(parents=True, exist_ok=True)
    import cv2

    cv2.imwrite(str(beside / picture), np.full((4, 4, 3), (10, 20, 200), np.uint8))
    (home / folder / "m.mtl").write_text(f"newmtl m\nmap_Kd {picture}\n")
    box = trimesh.creation.box((0.04, 0.05, 0.06))
    rows = [f"v {x} {y} {z}" for x, y, z in box.vertices] + ["vt 0.5 0.5"]
    rows += [f"f {a + 1}/1 {b + 1}/1 {c + 1}/1" for a, b, c in box.faces]
    mesh.write_text("mtllib m.mtl\nusemtl m\n" + "\n".join(rows) + "\n")
    model, _ = added(home, tmp_path / "objects")
    (look,) = model.looks
    assert look.texture is not None
    assert look.texture[0, 0].tolist() == [200, 20, 10]


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("a.urdf", "<robot", "it isn't XML"),
        ("a.urdf", "<robot><link/></robot>", "an object is one link with a mesh"),
        (
            "a.sdf",
            "<m><link><visual><geometry><mesh><uri>b.obj</uri></mesh></geometry></visual></link></m>",
            "isn't there",
        ),
        ("a.stl", "solid\nendsolid\n", "no triangles|can't be read"),
        ("a.step", "ISO-10303-21;", "one of the formats urdf, sdf"),
    ],
)
def test_what_is_no_object_is_refused(tmp_path, name, content, told):
    (tmp_path / name).write_text(content)
    with pytest.raises(DocumentError, match=told):
        added(tmp_path / name, tmp_path / "objects")
    assert not (tmp_path / "objects").exists()


def test_a_mass_that_is_no_number_is_told(tmp_path):
    trimesh.creation.box((0.04, 0.05, 0.06)).export(tmp_path / "b.obj")
    file = tmp_path / "a.sdf"
    file.write_text(f"<m><link><inertial><mass>1 kg</mass></inertial><visual>{MESH}</visual></link></m>")
    with pytest.raises(DocumentError, match="'1 kg' stands where a number is meant"):
        find_object(file)


@pytest.mark.parametrize("edge", [1.2, 4.0, 2e5])
def test_a_size_that_is_no_usual_unit_needs_a_scale(tmp_path, edge):
    trimesh.creation.box((edge, edge, edge)).export(tmp_path / "house.stl")
    with pytest.raises(DocumentError, match="which no hand holds: give a `--scale`"):
        added(tmp_path / "house.stl", tmp_path / "objects")
    model, _ = added(tmp_path / "house.stl", tmp_path / "objects", scale=0.05 / edge)
    assert model.size == pytest.approx((0.05, 0.05, 0.05))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("solids: [{box: [1, 1, -1]}]", "greater than 0"),
        ("solids: [{ball: 0.1, box: [1, 1, 1]}]", "box|ball"),
        ("solids: [{bent: [[0, 0, 0], [0, 0, 1]]}]", "needs a `radius`"),
        ("solids: [{turned: [[0.1, 0.5], [0.1, 0.2]]}]", "heights don't sink"),
        ("solids: [{bal: 0.1}]", "did you mean 'ball'"),
        ("solids: [{prism: [[0, 0], [1, 1], [2, 2]], height: 1}]", "is flat"),
        ("mesh: nowhere.stl", "no such mesh file"),
        ("", "either `solids` or a `mesh`"),
    ],
)
def test_a_wrong_file_says_what_is_wrong(tmp_path, text, told):
    file = tmp_path / "a.yaml"
    file.write_text(f"grip: 1\nmass: 0.1\n{text}\n")
    with pytest.raises(GripError, match=told):
        load_object(file)
