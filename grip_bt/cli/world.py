"""`grip world`: worlds, listed, shown, checked, made; also lists, checks and shows for `grip object`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from grip_bt.app.project.folder import Project, find_project
from grip_bt.app.project.worlds import checked_world
from grip_bt.base.errors import GripError, plural
from grip_bt.base.yaml.tree import read_file
from grip_bt.cli.parser import add_actions
from grip_bt.cli.terminal import tell
from grip_sim.simulation import start_simulation
from grip_sim.specs import WorldSpec
from grip_sim.worlds import BUILTIN, load_world, read_world, world_files

SEEDS = 20
"""Arrangements that `check` draws."""
Files = Callable[[Path], dict[str, Path]]
Faults = Callable[[str, Project], Iterator[GripError]]
here = partial(find_project, Path())


def add_world(parser: argparse.ArgumentParser) -> None:
    listing = partial(list_files, world_files, lambda file: read_world(str(file))[0].doc)
    checking = partial(check_files, world_files, _faults_of_world, "world")
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


def list_files(files_of: Files, told: Callable[[Path], str], args: argparse.Namespace) -> None:
    files = files_of(here().folder)

    def line(name: str, file: Path) -> str:
        try:
            return f"{name}: {told(file)}"
        except GripError as error:
            return f"{name}: wrong: {error}"

    data = {name: str(file) for name, file in files.items()}
    tell(args.json, data, (line(name, file) for name, file in files.items()))


def check_files(files_of: Files, faults: Faults, what: str, args: argparse.Namespace) -> int:
    """Print what is wrong with what is named, or with all that the project has of its own."""
    project = here()
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


def show_spec(args: argparse.Namespace, data: object, spec: WorldSpec, camera: str) -> None:
    tell(args.json, data)
    if args.picture is not None:
        take_picture(spec, camera, args.picture)
        print(f"{args.picture}: written", file=sys.stderr)


def _show_world(args: argparse.Namespace) -> None:
    project = here()
    spec = load_world(args.world, args.seed, project.folder, "" if project.file.robot is None else project.robot_source)
    show_spec(args, spec.to_json(), spec, args.camera)


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
    project = here()
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
