"""Settings files of a project: looked at, changed, saved. The page keeps the text; nothing is kept here.

Changes are of single values of a YAML text; comments, order and style of everything else stay.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any, Literal

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.error import YAMLError

from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import DocumentError, GripError, nearest
from grip_bt.base.message_store.text import text_of
from grip_bt.base.values import JointState, Pose
from grip_bt.base.yaml.models import Diagnostic, find
from grip_bt.base.yaml.tree import YamlValue, entries_of, parse, to_data
from grip_gui.editing.files import ChangedOnDiskError, TextFile
from grip_gui.project import ProjectFolder
from grip_gui.setup.kinds import JOINT_STATES, POSES, entries, kind_of
from grip_gui.setup.options import doubtful_names, options_of, templates_of, wrong_options
from grip_gui.setup.robot_facts import robot_facts
from grip_gui.wire.setup import SetupChange, SetupEntry, SetupSave, SetupText, SetupView
from grip_gui.wire.task import Problem

WIDTH = 140


class SettingsStore:
    """What the page asks about settings files."""

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
        """Return a file as it is, or as it would begin."""
        file = TextFile(self.folder.settings_file(path), path)
        text = file.read() if file.path.exists() else kind_of(path).blank
        return self._view(path, text, file.known)

    def check(self, request: SetupText) -> SetupView:
        """Return what a text would be; nothing is written."""
        return self._view(request.path, request.text, "")

    def change(self, request: SetupChange) -> SetupView:
        """Return the text with one value changed; nothing is written."""
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
        """Write a text. Raises ChangedOnDiskError: somebody else has changed the file since it was opened."""
        kind_of(request.path)
        file = TextFile(self.folder.settings_file(request.path), request.path)
        file.known = request.known
        if not request.over and (how := file.change()):
            raise ChangedOnDiskError(request.path, how)
        file.write(request.text)
        return self._view(request.path, request.text, file.known)

    def _view(self, path: str, text: str, known: str) -> SetupView:
        kind, home, tree, data = kind_of(path), self.folder.folder, None, None
        file = self.folder.settings_file(path)
        try:
            tree = parse(text, path)
            data = to_data(tree)
        except DocumentError as error:
            problems = [_problem((error.message, error.line or 1, error.column or 1))]
        options = options_of(kind.name, data, home)
        if tree is not None:
            faults = wrong_options(tree, data, options)
            # The reader of trajectories stops at the first name that isn't there, and says less of it.
            if not faults or kind.name != "trajectories":
                faults = [*kind.check(file, text, tree), *faults]
            named = data.get("robot") if kind.name == "project" and isinstance(data, dict) else None
            if wrong := robot_facts(named, home).get("error"):
                faults.append((f"robot: {wrong}", *find(tree, ("robot",))))
            doubts = doubtful_names(kind.name, tree, data, options, home)
            problems = [_problem(f, tree) for f in faults] + [_problem(d, tree, "warning") for d in doubts]
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


DIGITS = 9  # digits after the point of what was measured: nanometres, which no robot measures
_FILES: dict[type, str] = {Pose: POSES, JointState: JOINT_STATES}


def keep_value(folder: ProjectFolder, name: str, value: object) -> str:
    """Put a pose or a joint state into the file of its kind under a name; return the file's path."""
    if type(value) not in _FILES:
        raise GripError(f"a {type(value).__name__} can't be kept by name; poses and joint states can")
    keep_text(folder, _FILES[type(value)], name, text_of(value, DIGITS))
    return _FILES[type(value)]


def keep_text(folder: ProjectFolder, path: str, name: str, text: str) -> None:
    """Put a value that is written as YAML into a file of named messages; one of this name is replaced."""
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


# --- changes of a text ------------------------------------------------------------------------------------------------


class UnchangeableError(GripError):
    """A value can't be put into a text."""


def set_value(text: str, key: Sequence[str | int], value: object) -> str:
    """Return the text with a value put at a path of keys; mappings on the way are made.

    Raises:
        UnchangeableError: the text is no mapping in YAML, or something else stands on the way.
    """
    yaml, root = _loaded(text)
    parent = _parent(root, key, make=True)
    if isinstance(parent, list) and key[-1] == len(parent):
        parent.append(value)
    else:
        if isinstance(parent, list):
            _there(parent, key)
        parent[key[-1]] = value
    return _dumped(yaml, root)


def remove(text: str, key: Sequence[str | int]) -> str:
    """Return the text without what stands at a path of keys, and without mappings that this leaves empty above it."""
    yaml, root = _loaded(text)
    parent = _parent(root, key)
    _there(parent, key)
    del parent[key[-1]]
    for depth in range(len(key) - 1, 0, -1):
        above = _parent(root, key[:depth])
        if above[key[depth - 1]]:
            break
        del above[key[depth - 1]]
    return _dumped(yaml, root)


def rename(text: str, key: Sequence[str | int], name: str) -> str:
    """Return the text with another name for an entry, in its place; those that refer to it follow."""
    yaml, root = _loaded(text)
    parent, old = _parent(root, key), key[-1]
    if not isinstance(parent, CommentedMap):
        raise UnchangeableError(f"{_said(key)} has no name")
    _there(parent, key)
    if name in parent and name != old:
        raise UnchangeableError(f"{name!r} is taken; choose another name than {', '.join(map(str, parent))}")
    _rename_key(parent, old, name)
    if len(key) == 2:
        _follow(root, key[0], old, name)
    return _dumped(yaml, root)


def _rename_key(mapping: CommentedMap, old: object, new: str) -> None:
    """Give an entry another name, in its place and with its comment."""
    place, value, comment = list(mapping).index(old), mapping[old], mapping.ca.items.pop(old, None)
    del mapping[old]
    mapping.insert(place, new, value)
    if comment is not None:
        mapping.ca.items[new] = comment


def _follow(root: CommentedMap, kind: object, old: object, new: str) -> None:
    """Have those that refer to an arm, a hand or a sensor call it by its new name."""
    arms, ros = root.get("arms"), root.get("ros")
    for arm in arms.values() if kind == "hands" and isinstance(arms, dict) else ():
        if isinstance(arm, dict) and arm.get("hand") == old:
            arm["hand"] = new
    where = {"hands": "controllers", "arms": "controllers", "sensors": "cameras"}.get(str(kind))
    users = ros.get(where) if isinstance(ros, dict) else None
    if isinstance(users, CommentedMap) and old in users and new not in users:
        _rename_key(users, old, new)


def _loaded(text: str) -> tuple[YAML, Any]:
    yaml = YAML(typ="rt")
    yaml.preserve_quotes = True
    yaml.width = WIDTH
    yaml.indent(mapping=2, sequence=4, offset=2)
    try:
        root = yaml.load(text)
    except (YAMLError, ValueError, RecursionError) as error:
        reason = str(error).splitlines()[0]
        raise UnchangeableError(f"fix the text first, it is not valid YAML: {reason}") from None
    if root is None or root == {}:
        root = CommentedMap()
    if not isinstance(root, dict):
        raise UnchangeableError("fix the text first: it is not a mapping of keys to values")
    return yaml, root


def _dumped(yaml: YAML, root: object) -> str:
    out = io.StringIO()
    yaml.dump(root, out)
    return out.getvalue()


def _parent(root: Any, key: Sequence[str | int], make: bool = False) -> Any:
    at = root
    for depth, step in enumerate(key[:-1], 1):
        if make and isinstance(at, dict) and at.get(step) is None:
            at[step] = CommentedSeq() if isinstance(key[depth], int) else CommentedMap()
        _there(at, key[:depth])
        at = at[step]
        if not isinstance(at, dict | list):
            raise UnchangeableError(f"{_said(key[:depth])} is {at!r}, with nothing in it; remove it first")
    return at


def _there(parent: Any, key: Sequence[str | int]) -> None:
    known = range(len(parent)) if isinstance(parent, list) else parent
    if key[-1] not in known:
        raise UnchangeableError(f"{_said(key)} isn't there{nearest(str(key[-1]), map(str, known))}")


def _said(key: Sequence[str | int]) -> str:
    return "/".join(map(str, key))
