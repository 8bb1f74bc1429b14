"""`grip world`: lists simulated worlds, shows what a seed draws in one, takes a picture, checks and copies files."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from pathlib import Path

from grip_bt.app.project.folder import Project, find_project
from grip_bt.app.project.worlds import checked_world
from grip_bt.base.errors import GripError
from grip_bt.base.yaml.tree import read_file
from grip_sim import start_simulation
from grip_sim.specs import WorldSpec
from grip_sim.worlds import BUILTIN, load_world, read_world, world_files

SEEDS = 20
"""So many arrangements are drawn by `check`."""


def add_world(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    verbs = parser.add_subparsers(title="what to do", metavar="WHAT", required=True)
    listed = verbs.add_parser("list", help="the worlds of the project in this folder, and the built-in ones")
    show = verbs.add_parser("show", help="what stands in a world, which regions and cameras it has")
    check = verbs.add_parser("check", help="everything that is wrong with worlds' files; exit status 1 for errors")
    new = verbs.add_parser("new", help="copy a built-in world into the project, to be changed")
    show.add_argument("world", metavar="NAME|FILE", help="a world's name, or a path of its file")
    show.add_argument("--seed", type=int, default=0, metavar="N", help="of what is drawn; 0 without it")
    show.add_argument("--picture", type=Path, metavar="FILE", help="write what a camera sees after 1 s: .png or .jpg")
    show.add_argument("--camera", default="", metavar="NAME", help="that takes the picture; the world's last one else")
    check.add_argument("worlds", nargs="*", metavar="NAME|FILE", help="all of the project's without it")
    new.add_argument("name", metavar="NAME", help="of the new world: worlds/NAME.yaml")
    new.add_argument("--like", default="table", metavar="WORLD", help=f"what to copy: {', '.join(BUILTIN)}; or a file")
    for each in (listed, show):
        each.add_argument("--json", action="store_true", help="print one JSON object")
    for each, run in ((listed, _run_list), (show, _run_show), (check, _run_check), (new, _run_new)):
        each.set_defaults(run=run)


def _run_list(args: argparse.Namespace) -> int:
    files = world_files(find_project(Path.cwd()).folder)
    if args.json:
        print(json.dumps({name: str(path) for name, path in files.items()}))
        return 0
    for name in files:
        print(f"{name}: {_doc(name)}")
    return 0


def _doc(name: str) -> str:
    try:
        return read_world(name, find_project(Path.cwd()).folder)[0].doc
    except GripError as error:
        return f"wrong: {error}"


def _run_show(args: argparse.Namespace) -> int:
    project = find_project(Path.cwd())
    spec = load_world(args.world, args.seed, project.folder, "" if project.file.robot is None else project.robot_source)
    print(json.dumps(spec.to_json(), indent=2) if args.json else "\n".join(_told(spec)))
    if args.picture is not None:
        take_picture(spec, args.camera, args.picture)
        print(f"{args.picture}: written", file=sys.stderr)
    return 0


def _told(spec: WorldSpec) -> Iterator[str]:
    yield f"robot: {spec.robot}"
    for thing in spec.objects:
        size = f"radius {thing.radius:.3f} m" + ("" if thing.shape == "sphere" else f", height {thing.height:.3f} m")
        size = f"{Path(thing.model).stem}, {size}" if thing.model else size
        place = ", ".join(f"{each:.3f}" for each in thing.position)
        yield f"object {thing.name}: {size}, {thing.mass:.3f} kg, friction {thing.friction:g}, centre at {place}"
    yield from (f"fixture {box.name}" for box in spec.boxes)
    yield from (f"fixture {mesh.name}" for mesh in spec.meshes)
    for name, said in spec.articulated.items():
        yield f"articulated {name}: {said.kind}, {', '.join(said.measures(name))}"
    for region in spec.regions:
        size = " x ".join(f"{each:g}" for each in region.size)
        yield f"region {region.name}: {size} m" + (", a target" if region.target else "")
    for camera in spec.cameras:
        yield f"camera {camera.name}: {camera.width} x {camera.height} px"
    for name, condition in spec.judge.items():
        yield f"judge {name}: {condition}"
    for name, fault in spec.faults.items():
        yield f"fault {name}: {fault.fault}" + (f" of {fault.of}" if fault.of else "")


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


def _run_check(args: argparse.Namespace) -> int:
    project = find_project(Path.cwd())
    own = (name for name, file in world_files(project.folder).items() if file.parent.parent == project.folder)
    names = args.worlds or list(own)
    wrong = 0
    for name in names:
        faults = list(_faults(project, name))
        wrong += len(faults)
        for fault in faults:
            print(f"{name}: {fault}")
    print(f"{len(names)} worlds checked on {SEEDS} seeds: {wrong} errors")
    return int(wrong > 0)


def _faults(project: Project, name: str) -> Iterator[GripError]:
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


def _run_new(args: argparse.Namespace) -> int:
    project = find_project(Path.cwd())
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
    return 0
