"""`grip object`: things that worlds can hold: listed, shown, checked, brought in."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from grip_bt.app.project.folder import Project
from grip_bt.base.errors import GripError
from grip_bt.cli.parser import add_actions, number, whole
from grip_bt.cli.terminal import tell
from grip_bt.cli.world import check_files, here, list_files, show_spec
from grip_sim import objects
from grip_sim.specs import CameraSpec, ObjectSpec, WorldSpec
from grip_sim.worlds import load_world

if TYPE_CHECKING:
    from grip_sim.objects.body import ObjectModel

SPOT = (0.60, 0.0)
"""Where a thing stands on the table when its picture is taken [m]."""


def add_object(parser: argparse.ArgumentParser) -> None:
    listing = partial(list_files, objects.object_files, _about_object)
    checking = partial(check_files, objects.object_files, _faults_of_object, "object")
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
    positive = number(above=0)
    add.add_argument("--scale", type=positive, metavar="X", help="factor of its lengths; 0.001 for millimetres")
    add.add_argument("--mass", type=positive, metavar="KG", help="its mass (default: as its file says, or a guess)")
    add.add_argument("--friction", type=positive, metavar="MU", help="against hands and tables (default: 0.6)")
    add.add_argument(
        "--parts", type=whole(1), default=32, metavar="N", help="most convex parts (default: 32; 1: its hull)"
    )
    for each in (listed, show, check):
        each.add_argument("--json", action="store_true", help="print one JSON object")


def _about_object(file: Path) -> str:
    model = objects.load_object(file)
    size = " x ".join(f"{1e3 * edge:.0f}" for edge in model.size)
    return f"{model.doc or 'no doc'} ({size} mm, {model.mass:g} kg)"


def _faults_of_object(name: str, project: Project) -> Iterator[GripError]:
    try:
        objects.load_object(objects.object_file(name, project.folder))
    except GripError as error:
        yield error


def _show_object(args: argparse.Namespace) -> None:
    file = objects.object_file(args.object, here().folder)
    model = objects.load_object(file)
    show_spec(args, _facts(model), _on_a_table(model, file), "close")


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

    folder = here().folder
    name = args.name or args.path.resolve().stem.lstrip("0123456789_-").replace("-", "_").replace(" ", "_")
    if not name.isidentifier():
        raise GripError(f"{name!r} can't be an object's name: give one of letters, digits and _ by `--name`")
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
