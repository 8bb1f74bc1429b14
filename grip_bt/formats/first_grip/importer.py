"""Importing from a path: a task, a robot's configuration, single files of it, or a folder of all these."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from grip_bt.base.errors import DocumentError, GripError
from grip_bt.base.yaml.tree import parse, read_file, to_data
from grip_bt.formats.generated_files import manifests_text
from grip_bt.formats.imported import Imported, Issues
from grip_bt.formats.names import free, key_of
from grip_bt.task import FrozenDict, Task
from grip_bt.task.catalog.manifest import InputPort, Manifest, OutputPort, Parameter

from .configuration import Configuration, add_files, read_configuration
from .graphs import graph_task
from .original import GripContainer, GripState
from .project import MARK, MESSAGES, project_texts
from .settings import read_settings
from .steps import ImportContext
from .texts import text_task
from .to_task import task_of
from .words import is_hand, name_of, outcome_meanings


def import_grip(path: Path) -> Imported:
    """Read tasks and configurations of the first GRIP; nothing is run, and nothing is written.

    Args:
        path: an `.ini` file of a task or of a robot, a YAML file of a task or of a configuration, or a folder of such.

    Raises:
        DocumentError: it can't be read.
        GripError: there is nothing of the first GRIP in it, or a task is broken.
    """
    if not path.exists():
        raise GripError(f"{path}: there is no such file or folder")
    files = [path] if not path.is_dir() else sorted(p for p in path.rglob("*") if p.suffix in (".ini", ".yaml", ".yml"))
    found, issues = Configuration(), Issues()
    originals: list[GripContainer] = []
    loose: list[Path] = []
    for file in files:
        if file.suffix == ".ini":
            originals += _settings_file(file, found, issues)
        elif (data := _task_data(file)) is not None:
            originals.append(text_task(data, file.name))
        else:
            loose.append(file)
    seen = {name for names in found.sources.values() for name in names}
    add_files(found, [file for file in loose if file.name not in seen])
    if not originals and not found.parts:
        said = "".join(f"\n  {issue}" for issue in found.issues)
        raise GripError(f"{path}: there is no task and no configuration of the first GRIP in it{said}")
    texts = project_texts(found) if found.parts else {}
    copies = {found.scene.name: found.scene} if found.parts and found.scene is not None else {}
    tasks: dict[str, Task] = {}
    unknown: dict[str, GripState] = {}
    for root in originals:
        task = task_of(root, _context(found, unknown, issues))
        tasks[free(key_of(task.name), tasks)] = task
    if unknown:
        texts |= _nodes(unknown)
    return Imported(tasks, (*found.issues, *issues), files=texts, copies=copies)


def _settings_file(file: Path, found: Configuration, issues: Issues) -> list[GripContainer]:
    """Return the task of a file of settings; a robot's are added to the configuration."""
    settings = read_settings(file)
    if any(key[-1] == "container" for key in settings):
        root = graph_task(settings, file.name, issues)
        if root.name == "root":
            root.name = file.stem
        return [root]
    read = read_configuration(settings, file)
    for kind, named in read.parts.items():
        found.parts.setdefault(kind, {}).update(named)
        found.sources.setdefault(kind, []).extend(read.sources[kind])
    found.scene = read.scene or found.scene
    found.issues.extend(read.issues)
    return []


def _task_data(file: Path) -> Mapping[str, Any] | None:
    """Return a task in the older text form; None where the file is something else."""
    try:
        data = to_data(parse(read_file(file), str(file)))
    except DocumentError:
        return None
    return data if isinstance(data, dict) and isinstance(data.get("states"), list) else None


def _context(found: Configuration, unknown: dict[str, GripState], issues: Issues) -> ImportContext:
    return ImportContext(
        arms={group: key_of(group) for group in found.part("planners") if not is_hand(group)},
        sensors={name: key_of(name) for name in found.part("sensors")},
        components={n: (key_of(n), _count(said)) for n, said in found.part("components").items()},
        messages={kind: set(found.part(kind)) for kind in MESSAGES} if found.parts else {},
        unknown=unknown,
        issues=issues,
    )


def _count(said: Mapping[str, Any]) -> int:
    number = said.get("number_outcomes")
    return number if type(number) is int and 0 < number < 100 else 1


def _nodes(unknown: Mapping[str, GripState]) -> dict[str, str]:
    """Return a manifest and a class for each state that has to be filled in."""
    manifests, classes = [], []
    for id_, state in unknown.items():
        cls = "".join(word.capitalize() for word in id_.partition("/")[2].split("_"))
        outcomes = tuple(name_of(outcome) for outcome in state.outcomes) or ("success", "failure")
        slots = [key_of(slot) for slot in state.slots if slot != "output"]
        ports = {"output": OutputPort(type="Any", on=outcomes)} if state.slots.get("output") else {}
        manifest = Manifest(
            id=id_,
            doc=f"{state.type or state.name}, a state of the first GRIP.",
            implementation=f"leaves.py:{cls}",
            parameters=FrozenDict({slot: Parameter(type="Any", default=None) for slot in slots}),
            inputs=FrozenDict({slot: InputPort(type="Any", required=False) for slot in slots}),
            outputs=FrozenDict(ports),
            outcomes=FrozenDict(outcome_meanings(outcomes)),
        )
        manifests.append(manifest)
        classes.append(_class(cls, state, outcomes))
    head = (
        f'"""States of the first GRIP that have no equal; write what they do. {MARK}."""\n\nfrom grip_bt import Leaf\n'
    )
    return {
        "nodes/original/manifest.yaml": manifests_text(manifests, f"# {MARK}.\n"),
        "nodes/original/leaves.py": head + "".join(classes),
    }


def _class(cls: str, state: GripState, outcomes: tuple[str, ...]) -> str:
    about = f"{state.type or state.name} has to be written: read self.params, return self.end(one of {list(outcomes)})"
    doc = f"{state.type or state.name} of the first GRIP.".replace("\\", "").replace('"', "'")
    return (
        f'\n\nclass {cls}(Leaf):\n    """{doc}"""\n\n    def update(self):\n'
        f"        raise NotImplementedError({about!r})\n"
    )
