"""`grip world` and `grip object`: worlds and what can stand in them: listed, shown, checked, made."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from grip_bt.app.project.folder import Project, find_project
from grip_bt.app.project.worlds import checked_world
from grip_bt.base.errors import GripError, plural
from grip_bt.base.yaml.tree import read_file
from grip_bt.cli.parser import add_actions
from grip_bt.cli.terminal import tell
from grip_sim import objects
from grip_sim.simulation import start_simulation
from grip_sim.specs import CameraSpec, ObjectSpec, WorldSpec
from grip_sim.worlds import BUILTIN, load_world, read_world, world_files

if TYPE_CHECKING:
    from grip_sim.objects.body import ObjectModel

SEEDS = 20
"""Arrangements that `check` draws."""
Files = Callable[[Path], dict[str, Path]]
Faults = Callable[[str, Project], Iterator[GripError]]
SPOT = (0.60, 0.0)
"""Where a thing stands on the table when its picture is taken [m]."""
_here = partial(find_project, Path())


def add_world(parser: argparse.ArgumentParser) -> None:
    listing = partial(_list, world_files, _about_world)
    checking = partial(_check, world_files, _faults_of_world, "world")
    listed, show, check, new = add_actions(
        parser,
        {
            "list": (listing, "the worlds of the project in this folder, and the built-in ones"),
            "show": (_show_world, "what stands in a world, which regions and cameras it has"),
            "check": (checking, "all that is wrong with worlds' files, on 20 seeds; exit status 1 for errors"),
            "new": (_new_world, "copy a built-in world into the project, to be changed"),
        },
    )
    show.add_argument("world", metavar="NAME|FILE", help="a world's name, or a path of its file")
    show.add_argument("--seed", type=int, default=0, metavar="N", help="of what is drawn (default: 0)")
    show.add_argument("--picture", type=Path, metavar="FILE", help="write what a camera sees after 1 s: .png or .jpg")
    show.add_argument("--camera", default="", metavar="NAME", help="that takes it (default: the world's last one)")
    check.add_argument("names", nargs="*", metavar="NAME|FILE", help="which ones (default: all of the project's)")
    new.add_argument("name", metavar="NAME", help="of the new world: worlds/NAME.yaml")
    new.add_argument("--like", default="table", metavar="WORLD", help=f"what to copy: {', '.join(BUILTIN)}; or a file")
    for each in (listed, show, check):
        each.add_argument("--json", action="store_true", help="print one JSON object")


def add_object(parser: argparse.ArgumentParser) -> None:
    listing = partial(_list, objects.object_files, _about_object)
    checking = partial(_check, objects.object_files, _faults_of_object, "object")
    listed, show, check, add = add_actions(
        parser,
        {
            "list": (listing, "the objects of the project in this folder, and those of the library"),
            "show": (_show_object, "an object's size, mass, inertia and parts"),
            "check": (checking, "everything that is wrong with objects' files; exit status 1 for errors"),
            "add": (_add, "bring in a mesh, a URDF, an SDF, or a folder of YCB or Google Scanned Objects"),
        },
    )
    show.add_argument("object", metavar="NAME|FILE", help="an object's name, or a path of its file")
    show.add_argument("--picture", type=Path, metavar="FILE", help="write how it lies on a table: .png or .jpg")
    check.add_argument("names", nargs="*", metavar="NAME|FILE", help="which ones (default: all of the project's)")
    add.add_argument("path", type=Path, metavar="FILE|FOLDER", help="what to bring in; it is copied")
    add.add_argument("--name", default="", metavar="NAME", help="objects/NAME.yaml (default: as the file or folder)")
    add.add_argument("--scale", type=float, metavar="X", help="factor of its lengths; 0.001 for millimetres")
    add.add_argument("--mass", type=float, metavar="KG", help="its mass (default: as its file says, or a guess)")
    add.add_argument("--friction", type=float, metavar="MU", help="against hands and tables (default: 0.6)")
    add.add_argument("--parts", type=int, default=32, metavar="N", help="most convex parts (default: 32; 1: its hull)")
    for each in (listed, show, check):
        each.add_argument("--json", action="store_true", help="print one JSON object")


def _list(files_of: Files, told: Callable[[Path], str], args: argparse.Namespace) -> None:
    files = files_of(_here().folder)

    def line(name: str, file: Path) -> str:
        try:
            return f"{name}: {told(file)}"
        except GripError as error:
            return f"{name}: wrong: {error}"

    data = {name: str(file) for name, file in files.items()}
    tell(args.json, data, (line(name, file) for name, file in files.items()))


def _about_world(file: Path) -> str:
    return read_world(str(file))[0].doc


def _about_object(file: Path) -> str:
    model = objects.load_object(file)
    size = " x ".join(f"{1e3 * edge:.0f}" for edge in model.size)
    return f"{model.doc or 'no doc'} ({size} mm, {model.mass:g} kg)"


def _check(files_of: Files, faults: Faults, what: str, args: argparse.Namespace) -> int:
    """Print what is wrong with what is named, or with all that the project has of its own."""
    project = _here()
    own = [name for name, file in files_of(project.folder).items() if file.parent.parent == project.folder]
    names = args.names or own
    found = [(name, str(fault)) for name in names for fault in faults(name, project)]
    lines = (*map(": ".join, found), f"{plural(len(names), what)} checked: {plural(len(found), 'error')}")
    tell(args.json, {name: [fault for of, fault in found if of == name] for name in names}, lines)
    return int(bool(found))


def _faults_of_world(name: str, project: Project) -> Iterator[GripError]:
    """Yield what is wrong with a world, its arrangements and its conditions: the first of each."""
    found = checked_world(project, name)
    if isinstance(found, GripError):
        yield found
        return
    for seed in range(1, SEEDS):
        try:
            load_world(name, seed, project.folder)
        except GripError as error:
            yield GripError(f"seed {seed}: {error}")
            return


def _faults_of_object(name: str, project: Project) -> Iterator[GripError]:
    try:
        objects.load_object(objects.object_file(name, project.folder))
    except GripError as error:
        yield error


def _show(args: argparse.Namespace, data: object, spec: WorldSpec, camera: str) -> None:
    tell(args.json, data)
    if args.picture is not None:
        take_picture(spec, camera, args.picture)
        print(f"{args.picture}: written", file=sys.stderr)


def _show_world(args: argparse.Namespace) -> None:
    project = _here()
    spec = load_world(args.world, args.seed, project.folder, "" if project.file.robot is None else project.robot_source)
    _show(args, spec.to_json(), spec, args.camera)


def take_picture(spec: WorldSpec, camera: str, file: Path) -> None:
    """Write what a camera sees when everything has settled.

    Raises:
        UnknownNameError: the world has no such camera.
        GripError: it has none at all, or the picture can't be written.
    """
    import cv2

    if not spec.cameras:
        raise GripError("the world has no camera that could take a picture: add one under `cameras:`")
    with start_simulation(spec) as simulation:
        view = simulation.camera(camera or spec.cameras[-1].name)
        simulation.settle(1.0)
        shot = view.capture()
        shot.wait()
        frame = shot.result()
    try:
        written = cv2.imwrite(str(file), frame.image.pixels[:, :, ::-1])
    except cv2.error:
        written = False
    if not written:
        raise GripError(f"{file}: can't be written; a picture is a .png or .jpg file in a folder that is there")


def _new_world(args: argparse.Namespace) -> None:
    project = _here()
    if not args.name.isidentifier():
        raise GripError(f"{args.name!r} can't be a world's name: use letters, digits and _, as in my_table")
    file = project.folder / "worlds" / f"{args.name}.yaml"
    if file.exists():
        raise GripError(f"{file} is there already and was left alone; choose another name, or remove it first")
    _, source = read_world(args.like, project.folder)
    file.parent.mkdir(exist_ok=True)
    file.write_text(read_file(source))
    print(f"{file}: written; `world: {args.name}` in grip.yaml uses it")
    print(f"next: grip world show {args.name} --picture {args.name}.png")


def _show_object(args: argparse.Namespace) -> None:
    file = objects.object_file(args.object, _here().folder)
    model = objects.load_object(file)
    _show(args, _facts(model), _on_a_table(model, file), "close")


def _facts(model: ObjectModel) -> dict[str, object]:
    """Return an object's size [m], mass [kg], centre [m] and inertia about it [kg m^2], and so on."""
    data = {key: getattr(model, key) for key in ("name", "doc", "size", "mass", "friction")}
    return data | {
        "centre_of_mass": model.centre.tolist(),
        "inertia": model.inertia.tolist(),
        "parts": len(model.parts),
    }


def _on_a_table(model: ObjectModel, file: Path) -> WorldSpec:
    height, far = model.size[2], 2.2 * max(model.size) + 0.08
    (x, y), middle = SPOT, height / 2
    thing = ObjectSpec("thing", "model", model.radius, height, (x, y, middle + 1e-3), 0.0, model.mass, model.friction)
    eye = (x - 0.6 * far, y - 0.75 * far, middle + 0.55 * far)
    camera = CameraSpec("close", 640, 480, 0.6, eye, target=(x, y, middle))
    return replace(load_world("table"), objects=(replace(thing, model=str(file)),), cameras=(camera,))


def _add(args: argparse.Namespace) -> None:
    from grip_sim.objects.adding import check_mesh, find_object, write_object  # which needs trimesh

    folder = _here().folder
    name = args.name or args.path.resolve().stem.lstrip("0123456789_-").replace("-", "_").replace(" ", "_")
    if not name.isidentifier():
        raise GripError(f"{name!r} can't be an object's name: give one of letters, digits and _ by `--name`")
    for option in ("scale", "mass", "friction", "parts"):
        if (value := getattr(args, option)) is not None and not 0 < value < float("inf"):
            raise GripError(f"--{option} is a number above 0, not {value:g}")
    found = find_object(args.path)
    checked = check_mesh(found, args.scale, args.parts, lambda text: print(text, file=sys.stderr))
    own, source = folder / objects.FOLDER, str(args.path.name)
    file = write_object(name, found, checked, own, mass=args.mass, friction=args.friction, source=source)
    model = objects.load_object(file)
    hidden = " (it hides the library's)" if name in objects.BUILTIN else ""
    print(*(f"{name}: {remark}" for remark in checked.remarks), sep="\n")
    tell(False, _facts(model))
    print(f"{file}: written{hidden}; `model: {name}` in a world's file uses it")
    print(f"next: grip object show {name} --picture {name}.png")
