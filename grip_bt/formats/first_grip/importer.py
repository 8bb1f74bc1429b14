"""Importing from a path: a task, a robot's configuration, single files of it, or a folder of all these."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grip_bt.base.errors import DocumentError, GripError
from grip_bt.base.yaml.tree import parse, read_file, to_data
from grip_bt.task import FrozenDict, Task, dumps
from grip_bt.task.catalog.manifest import InputPort, Manifest, OutputPort, Parameter, manifest_text

from .configuration import Configuration, add_files, read_configuration
from .graphs import graph_task
from .original import Note, OriginalContainer, OriginalState
from .project import MARK, MESSAGES, project_texts
from .settings import read_settings
from .steps import Setting
from .texts import text_task
from .to_task import task_of
from .words import is_hand, key_of, meanings, name_of


@dataclass
class GripImport:
    """What became of it.

    Attributes:
        tasks: by name.
        texts: files of a project folder, by their path in it; tasks and what they need among them.
        copies: files that are copied as they are.
        notes: what isn't as it was, and what somebody has to look at.
    """

    tasks: dict[str, Task] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)
    copies: dict[str, Path] = field(default_factory=dict)
    notes: list[Note] = field(default_factory=list)


def import_grip(path: Path) -> GripImport:
    """Read tasks and configurations of the first GRIP; nothing is run, and nothing is written.

    Args:
        path: an `.ini` file of a task or of a robot, a YAML file of a task or of a configuration, or a folder of such.

    Raises:
        DocumentError: it can't be read.
        GripError: there is nothing of the first GRIP in it, or a task is broken.
    """
    files = [path] if not path.is_dir() else sorted(p for p in path.rglob("*") if p.suffix in (".ini", ".yaml", ".yml"))
    result, found = GripImport(), Configuration()
    tasks: list[tuple[Path, OriginalContainer, list[Note]]] = []
    loose: list[Path] = []
    for file in files:
        if file.suffix == ".ini":
            _settings_file(file, found, tasks)
        elif (data := _task_data(file)) is not None:
            tasks.append((file, text_task(data, file.name), []))
        else:
            loose.append(file)
    seen = {name for names in found.sources.values() for name in names}
    add_files(found, [file for file in loose if file.name not in seen])
    if not tasks and not found.parts:
        said = "".join(f"\n  {note}" for note in found.notes)
        raise GripError(f"{path}: there is no task and no configuration of the first GRIP in it{said}")
    if found.parts:
        result.texts |= project_texts(found)
        if found.scene is not None:
            result.copies[found.scene.name] = found.scene
    result.notes += found.notes
    unknown: dict[str, OriginalState] = {}
    for file, root, notes in tasks:
        _task(result, file, root, notes, found, unknown)
    if unknown:
        result.texts |= _nodes(unknown)
    return result


def _settings_file(file: Path, found: Configuration, tasks: list[tuple[Path, OriginalContainer, list[Note]]]) -> None:
    settings = read_settings(file)
    if any(key[-1] == "container" for key in settings):
        root, notes = graph_task(settings, file.name)
        if root.name == "root":
            root.name = file.stem
        tasks.append((file, root, notes))
        return
    read = read_configuration(settings, file)
    for kind, named in read.parts.items():
        found.parts.setdefault(kind, {}).update(named)
        found.sources.setdefault(kind, []).extend(read.sources[kind])
    found.scene = read.scene or found.scene
    found.notes += read.notes


def _task_data(file: Path) -> Mapping[str, Any] | None:
    """Return a task in the older text form; None where the file is something else."""
    try:
        data = to_data(parse(read_file(file), str(file)))
    except DocumentError:
        return None
    return data if isinstance(data, dict) and isinstance(data.get("states"), list) else None


def _task(
    result: GripImport,
    file: Path,
    root: OriginalContainer,
    notes: list[Note],
    found: Configuration,
    unknown: dict[str, OriginalState],
) -> None:
    setting = Setting(
        arms={group: key_of(group) for group in found.part("planners") if not is_hand(group)},
        sensors={name: key_of(name) for name in found.part("sensors")},
        components={n: (key_of(n), _count(said)) for n, said in found.part("components").items()},
        messages={kind: set(found.part(kind)) for kind in MESSAGES} if found.parts else {},
        unknown=unknown,
    )
    task = task_of(root, setting)
    stem = key_of(task.name)
    while f"tasks/{stem}.yaml" in result.texts:
        stem += "_2"
    result.tasks[stem] = task
    result.texts[f"tasks/{stem}.yaml"] = f"# {MARK} from {file.name}.\n{dumps(task)}"
    result.notes += [*notes, *setting.notes]


def _count(said: Mapping[str, Any]) -> int:
    number = said.get("number_outcomes")
    return number if type(number) is int and 0 < number < 100 else 1


def _nodes(unknown: Mapping[str, OriginalState]) -> dict[str, str]:
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
            outcomes=FrozenDict(meanings(outcomes)),
        )
        manifests.append("- " + manifest_text(manifest, "").rstrip("\n").replace("\n", "\n  "))
        classes.append(_class(cls, state, outcomes))
    header = f"# {MARK}.\n"
    head = (
        f'"""States of the first GRIP that have no equal; write what they do. {MARK}."""\n\nfrom grip_bt import Leaf\n'
    )
    return {
        "nodes/original/manifest.yaml": header + "\n".join(manifests) + "\n",
        "nodes/original/leaves.py": head + "".join(classes),
    }


def _class(cls: str, state: OriginalState, outcomes: tuple[str, ...]) -> str:
    about = f"{state.type or state.name} has to be written: read self.params, return self.end(one of {list(outcomes)})"
    doc = f"{state.type or state.name} of the first GRIP.".replace("\\", "").replace('"', "'")
    return (
        f'\n\nclass {cls}(Leaf):\n    """{doc}"""\n\n    def update(self):\n'
        f"        raise NotImplementedError({about!r})\n"
    )
