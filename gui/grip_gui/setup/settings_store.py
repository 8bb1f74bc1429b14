"""Settings files of a project: looked at, changed, saved. The page keeps the text; nothing is kept here."""

from __future__ import annotations

from typing import Literal

from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import DocumentError, GripError
from grip_bt.base.message_store.yaml import text_of
from grip_bt.base.values import JointState, Pose
from grip_bt.base.yaml.models import Diagnostic, find
from grip_bt.base.yaml.tree import YamlValue, entries_of, parse, to_data
from grip_gui.editing.files import ChangedOnDiskError, TextFile
from grip_gui.project import ProjectFolder
from grip_gui.wire.setup import SetupChange, SetupEntry, SetupSave, SetupText, SetupView
from grip_gui.wire.task import Problem

from .changes import UnchangeableError, remove, rename, set_value
from .kinds import JOINT_STATES, POSES, entries, kind_of
from .options import doubtful_names, options_of, robot_error, templates_of, wrong_options


class SettingsStore:
    """What the page asks about settings files.

    Args:
        folder: the project; no path leads out of it.
    """

    def __init__(self, folder: ProjectFolder):
        self.folder = folder

    def files(self) -> list[SetupEntry]:
        """Return all settings files; those that aren't there yet can be made."""
        try:
            components = find_project(self.folder.folder).component_folders()
        except GripError:  # grip.yaml is wrong; where components usually are is a good guess
            files = sorted(self.folder.folder.glob("components/*/component.yaml"))
            components = {file.parent.name: file.parent for file in files}
        return entries(self.folder, components)

    def open(self, path: str) -> SetupView:
        """Return a file as it is, or as it would begin.

        Raises:
            OutsideProjectError: the path is none of a settings file.
            DocumentError: it can't be read.
        """
        file = TextFile(self.folder.settings_file(path), path)
        text = file.read() if file.path.exists() else kind_of(path).blank
        return self._view(path, text, file.known)

    def check(self, request: SetupText) -> SetupView:
        """Return what a text would be; nothing is written."""
        return self._view(request.path, request.text, "")

    def change(self, request: SetupChange) -> SetupView:
        """Return the text with one value changed; nothing is written.

        Raises:
            UnchangeableError: it can't be.
        """
        match request.do:
            case "set":
                text = set_value(request.text, request.key, request.value)
            case "remove":
                text = remove(request.text, request.key)
            case "rename":
                if not isinstance(request.value, str) or not request.value:
                    raise UnchangeableError("a name is a text")
                text = rename(request.text, request.key, request.value)
        return self._view(request.path, text, "")

    def save(self, request: SetupSave) -> SetupView:
        """Write a text.

        Raises:
            ChangedOnDiskError: somebody else has changed the file since it was opened.
            DocumentError: it can't be written.
        """
        kind_of(request.path)
        file = TextFile(self.folder.settings_file(request.path), request.path)
        file.known = request.known
        if not request.over and (how := file.change()):
            raise ChangedOnDiskError(request.path, how)
        file.write(request.text)
        return self._view(request.path, request.text, file.known)

    def _view(self, path: str, text: str, known: str) -> SetupView:
        kind, home, data, problems = kind_of(path), self.folder.folder, None, []
        file = self.folder.settings_file(path)
        try:
            tree = parse(text, path)
        except DocumentError as error:
            options = options_of(kind.name, None, home)
            problems = [_problem((error.message, error.line or 1, error.column or 1))]
        else:
            data = to_data(tree)
            options = options_of(kind.name, data, home)
            faults = wrong_options(tree, data, options)
            # The reader of trajectories stops at the first name that isn't there, and says less of it.
            if not faults or kind.name != "trajectories":
                faults = [*kind.check(file, text, tree), *faults]
            if wrong := robot_error(kind.name, data, home):
                faults.append((f"robot: {wrong}", *find(tree, ("robot",))))
            problems = [_problem(fault, tree) for fault in faults]
            problems += [_problem(doubt, tree, "warning") for doubt in doubtful_names(kind.name, tree, data, home)]
        return SetupView(
            path=path,
            kind=kind.name,
            title=kind.title,
            text=text,
            known=known,
            data=data,
            shape=dict(kind.shape),
            options=options,
            templates=templates_of(kind, data, home),
            problems=sorted(problems, key=lambda problem: (problem.line, problem.column)),
        )


DIGITS = 9
"""Digits after the point of what was measured: nanometres, which no robot measures."""
_FILES: dict[type, str] = {Pose: POSES, JointState: JOINT_STATES}


def keep_value(folder: ProjectFolder, name: str, value: object) -> str:
    """Put a pose or a joint state into the file of its kind under a name; return the file's path.

    Raises:
        GripError: it is neither.
        DocumentError: the file can't be read or written.
    """
    if type(value) not in _FILES:
        raise GripError(f"a {type(value).__name__} can't be kept by name; poses and joint states can")
    keep_text(folder, _FILES[type(value)], name, text_of(value, DIGITS))
    return _FILES[type(value)]


def keep_text(folder: ProjectFolder, path: str, name: str, text: str) -> None:
    """Put a value that is written as YAML into a file of named messages; one of this name is replaced.

    Raises:
        DocumentError: the file can't be read or written.
    """
    file = TextFile(folder.settings_file(path), path)
    before = file.read() if file.path.exists() else kind_of(path).blank
    file.write(set_value(before, [name], to_data(parse(text))))


def _problem(
    fault: Diagnostic, tree: YamlValue | None = None, severity: Literal["error", "warning"] = "error"
) -> Problem:
    message, line, column = fault
    key = _keys_at(tree, line, column) if tree is not None else []
    return Problem(code="settings", severity=severity, message=message, line=line, column=column, key=key)


def _keys_at(tree: YamlValue, line: int, column: int) -> list[str]:
    """Return the keys on the way to the innermost entry that begins at a place; empty where none does."""
    found: list[str] = []
    todo: list[tuple[YamlValue, list[str]]] = [(tree, [])]
    while todo:
        value, above = todo.pop()
        for number, entry in enumerate(entries_of(value)):
            keys = [*above, entry.key or str(number)]
            if (entry.line, entry.column) == (line, column) and len(keys) > len(found):
                found = keys
            todo.append((entry.value, keys))
    return found
