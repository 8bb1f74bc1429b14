"""Writes the models of hands that come with us, from the packages that carry them, made small.

    pip download --no-deps robopianist==1.0.10 airo-models==0.0.12 gym-xarm==0.1.1     # unpack the wheels into FOLDER
    pip install trimesh fast-simplification
    python tools/bundle_models.py FOLDER

Meshes become OBJ files without normals, in steps of 0.01 mm, with at most `MOST` triangles (quadric decimation).
"""

from __future__ import annotations

import re
import shutil
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import trimesh
from mjcf_to_urdf import urdf_of_mjcf

HERE = Path(__file__).parent.parent / "grip_bt" / "commanders" / "robots"
MOST = 5000


def write_mesh(source: Path, target: Path) -> None:
    """Write a mesh as an OBJ file, with fewer triangles where it has too many."""
    mesh = trimesh.load(source, force="mesh", process=False)
    mesh = trimesh.Trimesh(mesh.vertices.round(5), mesh.faces)
    mesh.merge_vertices()
    mesh.update_faces(mesh.nondegenerate_faces())
    if len(mesh.faces) > MOST:
        mesh = mesh.simplify_quadric_decimation(face_count=MOST)
    mesh.remove_unreferenced_vertices()
    lines = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in np.asarray(mesh.vertices)]
    lines += [f"f {a} {b} {c}" for a, b, c in np.asarray(mesh.faces) + 1]
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text("\n".join(lines) + "\n")
    print(f"{target.relative_to(HERE)}: {len(mesh.faces)} triangles, {target.stat().st_size // 1000} kB")


def shadow_hand(folder: Path) -> None:
    """The E3M5, as MuJoCo's menagerie converted Shadow's own description."""
    source, target = folder / "robopianist/models/hands/third_party/shadow_hand", HERE / "shadow_hand"
    for mesh in sorted((source / "assets").glob("*.obj")):
        write_mesh(mesh, target / "assets" / mesh.name)
    shutil.copy(source / "LICENSE", target / "LICENSE")
    for side in ("left", "right"):
        robot, touching = urdf_of_mjcf(source / f"{side}_hand.xml")
        for mesh in robot.iter("mesh"):
            name = Path(mesh.get("filename", "")).name
            mesh.set("filename", f"package://grip_bt/commanders/robots/shadow_hand/assets/{name}")
        semantic = ET.Element("robot", name=robot.get("name", side))
        for one, other in sorted(touching):
            ET.SubElement(semantic, "disable_collisions", link1=one, link2=other, reason="Adjacent")
        for kind, root in (("urdf", robot), ("srdf", semantic)):
            ET.indent(root)
            (target / f"{side}_hand.{kind}").write_text(ET.tostring(root, encoding="unicode") + "\n")


def robotiq_2f_85(folder: Path) -> None:
    """Robotiq's 2F-85."""
    source, target = folder / "airo_models/grippers/robotiq_2f_85", HERE / "robotiq_2f_85"
    text = (source / "urdf/robotiq_2f_85.urdf").read_text()
    for name in sorted(set(re.findall(r'filename="([^"]+)"', text))):
        file = (source / "urdf" / name).resolve()
        kept = f"{file.parent.name}_{file.stem.removeprefix('robotiq_arg2f_').removeprefix('85_')}.obj"
        write_mesh(file, target / kept)
        text = text.replace(f'"{name}"', f'"{kept}"')
    (target / "robotiq_2f_85.urdf").write_text(text)
    shutil.copy(folder / "airo_models-0.0.12.dist-info/licenses/LICENSE", target / "LICENSE")


def xarm_gripper(folder: Path) -> None:
    """The shapes of UFACTORY's gripper; its linkage is written here."""
    source, target = folder / "gym_xarm/tasks/assets/mesh", HERE / "xarm_gripper"
    for name in ("base_link", "finger", "inner_knuckle", "outer_knuckle"):
        for side in ("left_", "right_") if name != "base_link" else ("",):
            write_mesh(source / f"{side}{name}.stl", target / f"{side}{name}.obj")
    shutil.copy(folder / "gym_xarm-0.1.1.dist-info/LICENSE", target / "LICENSE")


if __name__ == "__main__":
    packages = Path(sys.argv[1])
    shadow_hand(packages)
    robotiq_2f_85(packages)
    xarm_gripper(packages)
