"""The reference pages of the project's files, and JSON Schemas for editors, made from the models that read them.

`python tools/settings_reference.py docs` writes them; a test fails when one of them is older than the models.
"""

from __future__ import annotations

import ast
import inspect
import json
import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from textwrap import dedent
from types import UnionType
from typing import Annotated, Any, Literal, Union, cast, get_args, get_origin

from pydantic import BaseModel, ByteSize, RootModel, TypeAdapter
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from grip_bt.app.campaign.file import CampaignFile
from grip_bt.app.project.folder import ProjectFile
from grip_bt.app.runs.mocks import MocksFile
from grip_bt.commanders.description.config import MountConfig, PlacedConfig
from grip_bt.commanders.taught import TaughtFile
from grip_bt.task.catalog import CodePath
from grip_bt.task.catalog.component_file import ComponentFile
from grip_bt.task.catalog.port_type import PortType
from grip_bt.task.catalog.ros_config import Mount, RosRobotConfig
from grip_sim.objects.model import ObjectFile
from grip_sim.worlds.model import WorldFile

ROOT = Path(__file__).parents[1]
Mapped = type[Any]
"""A class whose fields are the keys of a mapping: a pydantic model, or a dataclass of pydantic's."""


@dataclass(frozen=True)
class FileKind:
    """One kind of file: its model, what it is called, what is said of it, and an example's path in the repository."""

    model: type[BaseModel]
    name: str
    about: str
    examples: tuple[str, ...]


@dataclass(frozen=True)
class Page:
    """One page of the reference."""

    name: str
    title: str
    about: str
    files: tuple[FileKind, ...]


OWN = "tools/reference_examples"
PAGES = (
    Page(
        "project_file.md",
        "Project file",
        """Look up the keys of `grip.yaml`, which makes a folder a project: its robot, its sensors, and where its parts
are. `grip new NAME` writes one, `grip check` tells what is wrong with it. Editors complete and check it by
[project.schema.json](project.schema.json); some need a first line
`# yaml-language-server: $schema=PATH/project.schema.json`.""",
        (
            FileKind(
                ProjectFile,
                "grip.yaml",
                "The demonstration's, and a real robot's ([robots](robots.md), [launching](launching.md)).",
                ("examples/grip.yaml", f"{OWN}/grip.yaml"),
            ),
        ),
    ),
    Page(
        "world_file.md",
        "World file",
        """Look up the keys of a world, which is what is simulated; [Worlds](worlds.md) tells how to make one, and
[Project file](project_file.md) how to read the tables. Things stand at `at` in the robot's base frame, z up. Editors
complete and check the file by [world.schema.json](world.schema.json).""",
        (FileKind(WorldFile, "worlds/NAME.yaml", "", (f"{OWN}/worlds/workbench.yaml",)),),
    ),
    Page(
        "other_files.md",
        "Other files of a project",
        """Look up the keys of components, campaigns, objects, taught states and mocks. [Project file](project_file.md)
tells how to read the tables.""",
        (
            FileKind(
                ComponentFile,
                "component.yaml",
                "External software as a node: `components/NAME/component.yaml`; see [components](components.md).",
                ("examples/components/antipodal_grasps/component.yaml",),
            ),
            FileKind(
                CampaignFile,
                "campaigns/NAME.yaml",
                "How often something works: `grip bench campaigns/NAME.yaml`; see [campaigns](campaigns.md).",
                ("examples/campaigns/two_forms.yaml",),
            ),
            FileKind(
                ObjectFile,
                "objects/NAME.yaml",
                "An object that worlds name by `model:`; see [objects](objects.md). Its z is up when it stands.",
                ("sim/grip_sim/objects/library/hammer.yaml",),
            ),
            FileKind(
                TaughtFile,
                "taught.yaml",
                "Written by `grip teach`, or by hand; see [teaching](commanders.md#teaching).",
                (f"{OWN}/taught.yaml",),
            ),
            FileKind(
                MocksFile,
                "mocks.yaml",
                "Read by `grip run --mocks FILE`; see [mocks](running.md#mocks).",
                (f"{OWN}/mocks.yaml",),
            ),
        ),
    ),
)
SCHEMAS: Mapping[str, tuple[type[BaseModel], str]] = {
    "project.schema.json": (ProjectFile, "GRIP project file"),
    "world.schema.json": (WorldFile, "GRIP world file"),
}
FORMS = {"project": ProjectFile, "component": ComponentFile, "world": WorldFile}
SHAPES = "../gui/grip_gui/setup/shapes.json"
"""Of the page's forms: with what each key means, which only the sources say."""
_HEAD = "# {title}\n\n{about}\n"
_LEGEND = """
`grip: 1` (or `campaign: 1`) is the version of the format and is required; `doc`, a sentence for people, may stand
almost anywhere. `name → X` is a mapping with an X for each name, `= X` is a default. A key without one may be left out
unless it is required.
"""
"""For all pages, on the first of them."""
_TITLES: Mapping[Mapped, str] = {
    Mount: "Sensor mount",
    MountConfig: "Hand mount",
    PlacedConfig: "Placed robot",
    PortType: "Port",
    RosRobotConfig: "ROS robot",
}
_COMMON = ("grip", "campaign", "doc")
"""Keys that the head of each page tells of."""
_PATTERNS = {
    r"^[a-z][a-z0-9_]*$": "name in lower case",
    r"^[A-Za-z_][A-Za-z0-9_]*$": "name",
    r"^(/[A-Za-z_][A-Za-z0-9_]*)+$": "ROS name",
    r"^[a-z][a-z0-9_]*/(srv|action|msg)/[A-Z][A-Za-z0-9]*$": "interface",
    r"^[a-z][a-z0-9_]*(\.[a-z][a-z0-9_]*)*$": "path of fields",
    r"^-?[a-z][a-z0-9_]*(\.[a-z][a-z0-9_]*)*$": "path of fields, perhaps after a minus",
    get_args(CodePath)[1].pattern: "import path",
}
_PLURALS = re.compile(r"^(integer|number|text|name|ROS name|import path)(?= |$)")


def described(model: type[BaseModel]) -> type[BaseModel]:
    """Give each field of a model, and of those in it, what its source says below it as description; return the model.

    Reading sources takes a while, so that only what shows the descriptions asks for them.
    """
    _describe(model, set())
    return model


def _describe(model: type[BaseModel], done: set[type[BaseModel]]) -> None:
    done.add(model)
    said = dict[str, str]()
    for base in reversed(model.__mro__):
        if not base.__module__.startswith("grip_") or "[" in base.__name__:
            continue  # pydantic's own, and what it makes of one that takes types
        body = cast("ast.ClassDef", ast.parse(dedent(inspect.getsource(base))).body[0]).body
        for key, doc in pairwise(body):
            if isinstance(key, ast.AnnAssign) and isinstance(doc, ast.Expr) and isinstance(doc.value, ast.Constant):
                said[cast("ast.Name", key.target).id] = inspect.cleandoc(str(doc.value.value))
    for name, field in model.model_fields.items():
        field.description = field.description or said.get(name)
        for part in {each for each in _parts_of(field.annotation) if issubclass(each, BaseModel)} - done:
            _describe(part, done)
    model.model_rebuild(force=True)


def _parts_of(annotation: object) -> Iterator[type]:
    if isinstance(annotation, type) and not get_args(annotation):
        yield annotation
    for part in get_args(annotation):
        yield from _parts_of(part)


class _Reference:
    """Writes the pages; each mapping is told of on the first page that has it, and linked from the others."""

    def __init__(self) -> None:
        self._home: dict[Mapped, tuple[str, str]] = {}
        self._page = ""

    def page(self, page: Page) -> str:
        self._page = page.name
        for file in page.files:
            described(file.model)
        found = [(file, self._below(file)) for file in page.files]
        parts = [_HEAD.format(title=page.title, about=page.about), *([_LEGEND] if page is PAGES[0] else [])]
        for file, places in found:
            parts.append(f"\n## {file.name}\n\n{file.about}\n" if file.about else f"\n## {file.name}\n")
            parts += [_example(path, file.name) for path in file.examples]
            root = file.model
            parts.append(self._root(root) if issubclass(root, RootModel) else self._table(root))
            for model, where in places.items():
                told = f" {_told(model)}"
                told = "" if f"|{told} |" in "".join(parts) else f":{told}"  # by the key that leads here
                parts.append(f"\n### {self._home[model][1]}\n\n{_listed(where)}{told}\n{self._table(model)}")
        return "".join(parts)

    def _below(self, file: FileKind) -> dict[Mapped, list[str]]:
        """Return the mappings that are told of first below a file's own, each with the places that hold it."""
        told: dict[Mapped, list[str]] = {}
        here, self._home[file.model] = [(file.model, "")], (self._page, file.name)
        for model, path in here:  # which grows on the way
            for key, field in _keys(model):
                for part, steps in _parts(field.annotation):
                    place = "/".join(step for step in (path, key, *steps) if step)
                    if part in told and part is not model:
                        told[part].append(place)
                    elif part not in self._home:
                        told[part] = [place]
                        self._home[part] = (self._page, _title(part))
                        here.append((part, place))
        return told

    def _root(self, model: type[RootModel[Any]]) -> str:
        annotation = model.model_fields["root"].annotation
        return f"\n{self.words(annotation)}: {_told(model)}\n"

    def _table(self, model: Mapped) -> str:
        rows, also = self._rows(model), ""
        for base in model.__mro__[1:]:  # what it has of another mapping is told there
            known = self._rows(base) if base in self._home else []
            if sum(row in known for row in rows) > 1:
                also = f"\nAlso the keys of {self.words(base)}.\n"
                rows = [row for row in rows if row not in known]
        rows = [["key", "type", "meaning"], ["---"] * 3, *rows]
        return "".join(f"\n| {' | '.join(row)} |" for row in rows) + f"\n{also}"

    def _rows(self, model: Mapped) -> list[list[str]]:
        """Return what is told of each key: itself, its type with the default, and its meaning."""
        attributes, rows = _attributes(model), []
        for key, field in _keys(model):
            if key in _COMMON:
                continue
            parts = [part for part, _ in _parts(field.annotation)]
            doc = field.description or attributes.get(key) or (_told(parts[0]) if parts else "")
            if not doc:
                raise ValueError(f"{model.__name__}.{key} has no docstring")
            type_ = self.words(_written(_ways(model, key, field), field.annotation), field.metadata)
            default = "" if field.is_required() else _shown(field.get_default(call_default_factory=True))
            type_ += ", required" if field.is_required() else f" = {default}" if default else ""
            rows.append([f"`{key}`", type_, _flat(doc).replace("|", r"\|")])
        return rows

    def words(self, annotation: Any, metadata: Iterable[Any] = ()) -> str:
        """Return a type in plain words, with what its metadata demand."""
        origin, inner = get_origin(annotation), get_args(annotation)
        if origin is Annotated:
            return self.words(_written(inner[1:], inner[0]), (*metadata, *inner[1:]))
        if origin in (Union, UnionType):
            options = [self.words(each, metadata) for each in inner if each is not type(None)]
            return _any_of([each for each in dict.fromkeys(options) if each != "integer" or "number" not in options])
        if origin is Literal:
            return _any_of([f"`{value}`" if value != "" else "empty" for value in inner])
        if isinstance(origin, type) and issubclass(origin, Mapping):
            value = self.words(inner[1])
            return f"name → {f'({value})' if ' or ' in value or '→' in value else value}"
        if origin in (tuple, list):
            return self._listed(inner, _limits(metadata, "min_length", "max_length"))
        if annotation in self._home:
            page, title = self._home[annotation]
            return f"[{title}]({'' if page == self._page else page}#{_anchor(title)})"
        if annotation is bool:
            return "`true`/`false`"
        if annotation in (int, float):
            return ("number" if annotation is float else "integer") + _range(metadata)
        if annotation is ByteSize:
            return "size"
        if annotation is str:
            pattern = _limits(metadata, "pattern").get("pattern")
            return "text" if pattern is None else _PATTERNS[pattern]
        return "any value"

    def _listed(self, inner: Sequence[Any], limits: Mapping[str, Any], within: bool = False) -> str:
        if Ellipsis in inner and get_origin(inner[0]) is tuple:
            words = [self._listed(get_args(inner[0]), {}, within=True)]
        else:
            words = [self.words(each) for each in inner if each is not Ellipsis]
        if Ellipsis in inner or len(inner) == 1:
            least = f" (at least {limits['min_length']})" if "min_length" in limits else ""
            return f"list of {_several(words[0])}{least}"
        if len(set(words)) == 1 and not within:
            return f"{len(words)} {_several(words[0])}"
        return f"[{', '.join(words)}]"


def reference() -> dict[str, str]:
    """Return every page and schema: the file's name -> its text."""
    writer = _Reference()
    shapes = {name: described(model).model_json_schema() for name, model in FORMS.items()}
    return (
        {page.name: writer.page(page) for page in PAGES}
        | {name: _schema(model, title) for name, (model, title) in SCHEMAS.items()}
        | {SHAPES: json.dumps(shapes, indent=1, ensure_ascii=False) + "\n"}
    )


def _schema(model: type[BaseModel], title: str) -> str:
    made = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **described(model).model_json_schema(by_alias=True),
    }
    return json.dumps({**made, "title": title}, indent=2, ensure_ascii=False) + "\n"


def _keys(model: Mapped) -> Iterator[tuple[str, FieldInfo]]:
    if issubclass(model, BaseModel):
        model.model_rebuild()
        if issubclass(model, RootModel):
            yield "", model.model_fields["root"]
            return
    for name, field in model.__pydantic_fields__.items():
        yield field.alias or name, field


def _ways(model: Mapped, key: str, field: FieldInfo) -> list[Any]:
    """Return what reads a field before its type does."""
    decorators = model.__pydantic_decorators__.field_validators.values()
    return [each.info for each in decorators if key in each.info.fields] + list(field.metadata)


def _written(ways: Iterable[Any], type_: Any) -> Any:
    """Return the type of what a file may hold, which validators turn into `type_`."""
    said = [way.json_schema_input_type for way in ways if hasattr(way, "json_schema_input_type")]
    return next((each for each in said if each is not PydanticUndefined), type_)


def _parts(annotation: Any, steps: tuple[str, ...] = ()) -> Iterator[tuple[Mapped, tuple[str, ...]]]:
    """Yield the mappings that a type speaks of, each with the steps from the key to it."""
    if isinstance(annotation, type) and hasattr(annotation, "__pydantic_fields__"):
        yield annotation, steps
    origin = get_origin(annotation)
    if isinstance(origin, type) and issubclass(origin, Mapping):
        steps = (*steps, "NAME")
    elif origin in (tuple, list):
        steps = (*steps, "N")
    for inner in get_args(annotation) if origin is not Literal else ():
        yield from _parts(inner, steps)


def _title(model: Mapped) -> str:
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", re.sub(r"(Config|Spec)$", "", model.__name__))
    return _TITLES.get(model, words.capitalize())


def _anchor(title: str) -> str:
    return re.sub(r"\s+", "-", re.sub(r"[^\w\s-]", "", title.lower()))


def _listed(places: Sequence[str]) -> str:
    return ", ".join(f"`{place}`" for place in dict.fromkeys(places))


def _flat(doc: str) -> str:
    return re.sub(r"docs/(\w+)\.md", r"[\1](\1.md)", " ".join(doc.split()).replace(" -> ", " → "))


def _told(model: Mapped) -> str:
    return _flat((model.__doc__ or "").split("\n    Attributes:")[0])


def _attributes(model: Mapped) -> dict[str, str]:
    """Return what a dataclass's docstring says of its fields."""
    said = (model.__doc__ or "").partition("\n    Attributes:")[2]
    return {key: doc[:1].upper() + doc[1:] for key, doc in re.findall(r"^ {8}(\w+): (.*)$", said, re.MULTILINE)}


def _limits(metadata: Iterable[Any], *names: str) -> dict[str, Any]:
    """Return those of a type's limits that are set."""
    found: dict[str, Any] = {}
    for each in metadata:
        if isinstance(each, FieldInfo):
            found |= _limits(each.metadata, *names)
        found |= {name: getattr(each, name) for name in names if getattr(each, name, None) is not None}
    return found


def _range(metadata: Iterable[Any]) -> str:
    signs = {"gt": ">", "ge": "≥", "lt": "<", "le": "≤"}
    limits = [
        f"{signs[name]} {value:{',' if isinstance(value, int) else '.4g'}}"
        for name, value in _limits(metadata, *signs).items()
    ]
    return f" {' and '.join(limits)}" if limits else ""


def _any_of(options: Sequence[str]) -> str:
    return " or ".join([", ".join(options[:-1]), options[-1]] if len(options) > 1 else options)


def _several(words: str) -> str:
    return f"({words})" if " or " in words else _PLURALS.sub(r"\1s", words)


def _shown(value: Any) -> str:
    """Return a default as the file would say it; nothing for what is empty."""
    if isinstance(value, ByteSize):
        return f"`{value.human_readable(decimal=True, separator=' ').replace('.0 ', ' ')}`"
    if isinstance(value, BaseModel):
        value = value.model_dump(exclude_defaults=True)
    if value is None or value in ("", {}, (), []):
        return ""
    if isinstance(value, float):
        value = float(f"{value:.4g}")
    said = TypeAdapter(Any).dump_json(value).decode()
    return f"`{re.sub(r'[{}]|(?<=[:,])', lambda m: m[0] or ' ', said.replace(chr(34), ''))}`"


def _example(path: str, name: str) -> str:
    title = name.replace("NAME", Path(path).stem)
    return f'\n```yaml title="{title}"\n{(ROOT / path).read_text(encoding="utf-8").rstrip()}\n```\n'


if __name__ == "__main__":
    for name, text in reference().items():
        (Path(sys.argv[1]) / name).write_text(text, encoding="utf-8")
