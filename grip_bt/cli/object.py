"""`grip object`: lists things that worlds can hold, shows them, and brings in other people's."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import GripError
from grip_bt.cli.world import take_picture
from grip_sim.objects import BUILTIN, FOLDER, load_object, object_file, object_files
from grip_sim.objects.adding import PARTS, check_mesh, find_object, write_object
from grip_sim.objects.body import ObjectModel
from grip_sim.specs import CameraSpec, ObjectSpec, WorldSpec
from grip_sim.worlds import load_world

SPOT = (0.60, 0.0)
"""Where a thing stands on the table when its picture is taken [m]."""


def add_object(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    verbs = parser.add_subparsers(title="what to do", metavar="WHAT", required=True)
    listed = verbs.add_parser("list", help="the objects of the project in this folder, and those of the library")
    show = verbs.add_parser("show", help="an object's size, mass, inertia and parts")
    check = verbs.add_parser("check", help="everything that is wrong with objects' files; exit status 1 for errors")
    add = verbs.add_parser("add", help="bring in a mesh, a URDF, an SDF, or a folder of YCB or Google Scanned Objects")
    show.add_argument("object", metavar="NAME|FILE", help="an object's name, or a path of its file")
    show.add_argument("--picture", type=Path, metavar="FILE", help="write how it lies on a table: .png or .jpg")
    check.add_argument("objects", nargs="*", metavar="NAME|FILE", help="all of the project's without it")
    add.add_argument("path", type=Path, metavar="FILE|FOLDER", help="what to bring in; it is copied")
    add.add_argument("--name", default="", metavar="NAME", help="objects/NAME.yaml; the file's or folder's name else")
    add.add_argument("--scale", type=float, metavar="X", help="factor of its lengths; 0.001 for millimetres")
    add.add_argument("--mass", type=float, metavar="KG", help="what it weighs; what its file says, or a guess, else")
    add.add_argument("--friction", type=float, metavar="MU", help="against hands and tables; 0.6 without it")
    add.add_argument("--parts", type=int, default=PARTS, metavar="N", help=f"most convex parts, {PARTS}; 1: its hull")
    for each in (listed, show):
        each.add_argument("--json", action="store_true", help="print one JSON object")
    for each, run in ((listed, _run_list), (show, _run_show), (check, _run_check), (add, _run_add)):
        each.set_defaults(run=run)


def _run_list(args: argparse.Namespace) -> int:
    files = object_files(find_project(Path.cwd()).folder)
    if args.json:
        print(json.dumps({name: str(path) for name, path in files.items()}))
        return 0
    for name, path in files.items():
        try:
            model = load_object(path)
            print(f"{name}: {model.doc or 'no doc'} ({_size(model)}, {model.mass:g} kg)")
        except GripError as error:
            print(f"{name}: wrong: {error}")
    return 0


def _size(model: ObjectModel) -> str:
    return " x ".join(f"{1e3 * edge:.0f}" for edge in model.size) + " mm"


def _run_show(args: argparse.Namespace) -> int:
    file = object_file(args.object, find_project(Path.cwd()).folder)
    model = load_object(file)
    print(json.dumps(_data(model)) if args.json else "\n".join(_told(model)))
    if args.picture is not None:
        take_picture(_on_a_table(model, file), "close", args.picture)
        print(f"{args.picture}: written", file=sys.stderr)
    return 0


def _data(model: ObjectModel) -> dict[str, object]:
    return {
        "name": model.name,
        "doc": model.doc,
        "size": model.size,
        "mass": model.mass,
        "friction": model.friction,
        "centre_of_mass": model.centre.tolist(),
        "inertia": model.inertia.tolist(),
        "parts": len(model.parts),
    }


def _told(model: ObjectModel) -> Iterator[str]:
    yield f"{model.name}: {model.doc or 'no doc'}"
    yield f"size: {_size(model)}"
    yield f"mass: {model.mass:g} kg, friction {model.friction:g}"
    centre = ", ".join(f"{1e3 * each:.1f}" for each in model.centre)
    yield f"centre of mass: {centre} mm from the middle of its bounding box"
    rows = "; ".join(", ".join(f"{1e6 * each:.4g}" for each in row) for row in model.inertia)
    yield f"inertia about it: {rows} kg mm^2"
    yield f"convex parts: {len(model.parts)}"


def _on_a_table(model: ObjectModel, file: Path) -> WorldSpec:
    height, far = model.size[2], 2.2 * max(model.size) + 0.08
    x, y = SPOT
    thing = ObjectSpec(
        "thing", "model", model.radius, height, (x, y, height / 2 + 1e-3), mass=model.mass, model=str(file)
    )
    eye = (x - 0.6 * far, y - 0.75 * far, height / 2 + 0.55 * far)
    camera = CameraSpec("close", 640, 480, 0.6, eye, target=(x, y, height / 2))
    return replace(load_world("table"), objects=(replace(thing, friction=model.friction),), cameras=(camera,))


def _run_check(args: argparse.Namespace) -> int:
    folder = find_project(Path.cwd()).folder
    own = [name for name in object_files(folder) if (folder / FOLDER / f"{name}.yaml").is_file()]
    names, wrong = args.objects or own, 0
    for name in names:
        try:
            load_object(object_file(name, folder))
        except GripError as error:
            wrong += 1
            print(f"{name}: {error}")
    print(f"{len(names)} objects checked: {wrong} errors")
    return int(wrong > 0)


def _run_add(args: argparse.Namespace) -> int:
    folder = find_project(Path.cwd()).folder
    name = args.name or args.path.resolve().stem.lstrip("0123456789_-").replace("-", "_").replace(" ", "_")
    if not name.isidentifier():
        raise GripError(f"{name!r} can't be an object's name: give one of letters, digits and _ by `--name`")
    for option in ("scale", "mass", "friction", "parts"):
        if (value := getattr(args, option)) is not None and not 0 < value < float("inf"):
            raise GripError(f"--{option} is a number above 0, not {value:g}")
    found = find_object(args.path)
    checked = check_mesh(found, args.scale, args.parts, lambda text: print(text, file=sys.stderr))
    source = str(args.path.name)
    file = write_object(name, found, checked, folder / FOLDER, mass=args.mass, friction=args.friction, source=source)
    for remark in checked.remarks:
        print(f"{name}: {remark}")
    print("\n".join(_told(load_object(file))))
    hidden = " (it hides the library's)" if name in BUILTIN else ""
    print(f"{file}: written{hidden}; `model: {name}` in a world's file uses it")
    print(f"next: grip object show {name} --picture {name}.png")
    return 0
