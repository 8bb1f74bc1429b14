"""Other people's objects: a mesh, a URDF, an SDF, or a folder of the YCB or Google Scanned Objects sets, brought in.

What is missing is said and taken from the volume; concave meshes fall into convex parts by CoACD (Wei et al., SIGGRAPH
2022), which are kept beside the mesh.
"""

from __future__ import annotations

import shutil
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from grip_bt.base.arrays import Array
from grip_bt.base.errors import DocumentError, GripError
from grip_sim.cameras.mesh_files import FORMATS, joined, read_mesh

DENSITY = 400.0
"""Density of things without a stated mass: between wood and hollow plastic [kg/m^3]."""
SIZES = (0.005, 1.0)
"""Least and greatest length of something that a hand may grasp [m]."""
THRESHOLD, PARTS = 0.05, 32
"""CoACD's: how far, relatively, parts may be from the mesh; and how many there may be."""
_QUICK = dict(preprocess_resolution=30, resolution=1000, mcts_iterations=40, decimate=True, max_ch_vertex=64)
"""A third of the time that CoACD takes by default."""
CONVEX = 0.98
"""A mesh that fills this share of its hull is taken as convex."""
_FOLDERS = ("google_16k/textured.obj", "google_64k/textured.obj", "google_16k/nontextured.stl", "poisson/textured.obj",
            "tsdf/textured.obj", "model.sdf", "meshes/model.obj")  # fmt: skip
"""Where YCB and Google Scanned Objects keep what they consist of, the better first."""
_COMPANIONS = (".mtl", ".png", ".jpg", ".jpeg", ".bin")


@dataclass(frozen=True)
class Found:
    """What somebody's file says of an object, with the mesh that it collides by if that is another; mass in kg."""

    mesh: Path
    collision: Path | None = None
    scale: float = 1.0
    mass: float | None = None
    friction: float | None = None


def find_object(path: Path) -> Found:
    """Return what a file or a folder holds. Raises DocumentError where it is no object, or its mesh isn't there."""
    if path.is_dir():
        inside = [path / each for each in _FOLDERS if (path / each).is_file()]
        inside += sorted(f for f in path.iterdir() if f.suffix.lower() in (".urdf", ".sdf", *FORMATS))
        if not inside:
            what = f"there is no object in it: none of {', '.join(_FOLDERS)}, no mesh, URDF or SDF"
            raise DocumentError(what, str(path))
        return find_object(inside[0])
    if not path.is_file():
        raise DocumentError("there is no such file or folder", str(path))
    suffix = path.suffix.lower()
    if suffix in (".urdf", ".sdf"):
        return _described(path)
    if suffix not in FORMATS:
        known = ", ".join(("urdf", "sdf", *(each[1:] for each in FORMATS)))
        raise DocumentError(f"an object is a folder, or a file of one of the formats {known}", str(path))
    return Found(path)


def _described(path: Path) -> Found:
    try:
        document = ET.fromstring(path.read_bytes())
    except ET.ParseError as error:
        raise DocumentError(f"it isn't XML: {error}", str(path)) from None
    links = [link for link in document.iter("link") if link.find(".//mesh") is not None]
    if len(links) != 1:
        said = "links" if links else "link"
        raise DocumentError(f"an object is one link with a mesh; it has {len(links) or 'no such'} {said}", str(path))
    visual, collision = (_mesh(links[0].find(f"{kind}/geometry/mesh"), path) for kind in ("visual", "collision"))
    mesh, scale = visual or collision or (path, 1.0)
    mass = links[0].find("inertial/mass")
    weight = None if mass is None else mass.get("value") or mass.text
    friction = links[0].findtext(".//friction/ode/mu")
    own = collision[0] if collision is not None and collision != visual and collision[1] == scale else None
    return Found(mesh, own, scale, *(_number(text, path) if text else None for text in (weight, friction)))


def _number(text: str, path: Path) -> float:
    try:
        return float(text)
    except ValueError:
        raise DocumentError(f"{text.strip()!r} stands where a number is meant", str(path)) from None


def _mesh(element: ET.Element | None, path: Path) -> tuple[Path, float] | None:
    if element is None:
        return None
    name = element.get("filename") or element.findtext("uri") or ""
    scale = {_number(word, path) for word in (element.get("scale") or element.findtext("scale") or "1").split()}
    if len(scale) > 1:
        what = f"its mesh is scaled differently along its axes, {sorted(scale)}: scale the mesh itself"
        raise DocumentError(what, str(path))
    local = Path(name.partition("://")[2] or name)
    for file in (path.parent / local, path.parent.joinpath(*local.parts[1:])):
        if file.is_file():
            return file, scale.pop()
    raise DocumentError(f"its mesh {name!r} isn't there: looked for {path.parent / local}", str(path))


@dataclass(frozen=True, eq=False)
class Checked:
    """A mesh that was looked at.

    Attributes:
        parts: corners of convex parts [m, as the file has them].
        volume: scaled [m^3].
        scale: factor of lengths.
        remarks: what was found and what was done about it, a sentence each.
    """

    parts: tuple[Array, ...]
    volume: float
    scale: float
    remarks: tuple[str, ...]


def check_mesh(found: Found, scale: float | None, parts: int, progress: Callable[[str], None]) -> Checked:
    """Return a mesh's convex parts and size, and what is remarkable about them.

    Args:
        scale: factor of lengths; None for that of its file, or a guess where a mesh alone can't be in metres.
        parts: most convex parts; 1 for its hull.

    Raises DocumentError where it has no volume, or a size that no hand can hold.
    """
    whole = joined(read_mesh(found.collision or found.mesh))
    remarks = []
    if not whole.is_watertight:
        remarks.append("its surface isn't closed: volume and inertia are those of its convex parts")
    factor = scale or found.scale
    longest = float(whole.extents.max()) * factor
    if scale is None and not SIZES[0] <= longest <= SIZES[1]:
        bare = found.mass is None and longest > 5 * SIZES[1]
        guess = next((f for f in (1e-3, 1e-2) if bare and SIZES[0] <= longest * f <= SIZES[1]), None)
        if guess is None:
            raise DocumentError(f"it is {longest:g} m long, which no hand holds: give a `--scale`", str(found.mesh))
        factor *= guess
        remarks.append(f"it would be {longest:g} m long: its lengths are taken times {factor:g}")
    hull = whole.convex_hull
    convex = whole.is_volume and whole.volume > CONVEX * hull.volume
    points: list[Array] = [np.array(hull.vertices)]
    if parts > 1 and not convex:
        progress(f"{found.mesh.name}: falling into convex parts, which may take a minute; `--parts 1` takes its hull")
        points = _decomposed(whole, parts)
        remarks.append(f"{len(points)} convex parts")
    else:
        remarks.append("it is convex" if convex else "its hull is what it collides by")
    volume = whole.volume if whole.is_volume else sum(trimesh.convex.convex_hull(p).volume for p in points)
    return Checked(tuple(points), float(volume) * factor**3, factor, tuple(remarks))


def _decomposed(whole: trimesh.Trimesh, most: int) -> list[Array]:
    import coacd

    coacd.set_log_level("error")
    mesh = coacd.Mesh(whole.vertices, whole.faces)
    found = coacd.run_coacd(mesh, threshold=THRESHOLD, max_convex_hull=most, seed=0, **_QUICK)
    return [np.array(points) for points, _ in found]


def write_object(
    name: str, found: Found, checked: Checked, folder: Path, *, mass: float | None, friction: float | None, source: str
) -> Path:
    """Write an object's file, with mesh and parts beside it, and return it. Raises GripError where there is one."""
    file, own = folder / f"{name}.yaml", folder / name
    if file.exists() or own.exists():
        raise GripError(f"{file} is there already and was left alone: choose another `--name`")
    own.mkdir(parents=True)
    for each in {found.mesh, *_companions(found.mesh)}:
        shutil.copyfile(each, own / each.name)
    scene = trimesh.Scene({f"part_{k}": trimesh.convex.convex_hull(p) for k, p in enumerate(checked.parts)})
    (own / "parts.obj").write_text(trimesh.exchange.obj.export_obj(scene, include_color=False, include_texture=False))
    weight = mass or found.mass or max(DENSITY * checked.volume, 1e-3)
    lines = [
        "grip: 1",
        f"mesh: {name}/{found.mesh.name}",
        f"parts: {name}/parts.obj",
        f"scale: {checked.scale:g}",
        f"mass: {weight:.4g}" + ("" if mass or found.mass else f"  # its volume at {DENSITY:g} kg/m^3: weigh it"),
        f"friction: {0.6 if (friction or found.friction) is None else friction or found.friction:g}",
        f"source: {source!r}",
    ]
    file.write_text("\n".join(lines) + "\n")
    return file


def _companions(mesh: Path) -> set[Path]:
    """Return the files beside a mesh, or in its set's folder of textures, that its text names."""
    places = (mesh.parent, mesh.parent.parent / "materials" / "textures")
    beside = [f for place in places if place.is_dir() for f in place.iterdir() if f.is_file() and f != mesh]
    named, text = set[Path](), mesh.read_bytes()
    for _ in range(2):  # a mesh names its materials, and they name pictures
        new = {f for f in beside if f.suffix.lower() in _COMPANIONS and f.name.encode() in text}
        text += b"".join(f.read_bytes() for f in new if f.suffix == ".mtl")
        named |= new
    return named
