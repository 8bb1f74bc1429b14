"""A node's manifest: ports, parameters, outcomes and documentation, read and written as YAML."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, StringConstraints, model_validator

from grip_bt.base.errors import DocumentError, listing, nearest
from grip_bt.base.frozen import FrozenDict
from grip_bt.base.types import Value, parse_type
from grip_bt.base.yaml.models import check_model, document_error
from grip_bt.base.yaml.tree import YamlList, YamlMapping, from_data, parse, read_file
from grip_bt.base.yaml.writer import write
from grip_bt.task.model import Meaning, Name

from .project_parts import Names

MOVES = ("arm", "hand", "component", "ros")
"""Groups of built-in nodes whose work reaches beyond this process."""
NodeId = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*(/[A-Za-z0-9_]+)+$")]


def _known_type(name: str) -> str:
    parse_type(name)
    return name


TypeName = Annotated[str, AfterValidator(_known_type)]
"""The name of a type of values, such as `list[Grasp]`."""


class _ManifestPart(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Parameter(_ManifestPart):
    """A literal that a task gives under `with:`."""

    type: TypeName
    doc: str = ""
    default: object = None
    names: Names | None = None
    """What of the project it names, so that names that don't exist are reported before a run."""

    @property
    def required(self) -> bool:
        """Whether a task must give it."""
        return "default" not in self.model_fields_set


class InputPort(_ManifestPart):
    """A value that a node reads from the variable bound under `in:`."""

    type: TypeName
    doc: str = ""
    required: bool = True


class OutputPort(_ManifestPart):
    """A value that a node writes, when it ends, to the variable bound under `out:`."""

    type: TypeName
    doc: str = ""
    on: tuple[str, ...] = ()
    """Outcomes with which it is written; empty means with every outcome whose meaning is success."""


class Manifest(_ManifestPart):
    """One kind of leaf."""

    id: NodeId
    doc: str
    implementation: str
    """Where the leaf is: `package.module:Class`, or `file.py:Class` relative to the manifest's folder."""
    parameters: FrozenDict[str, Parameter] = FrozenDict()
    inputs: FrozenDict[str, InputPort] = FrozenDict()
    outputs: FrozenDict[str, OutputPort] = FrozenDict()
    outcomes: FrozenDict[Name, Meaning] = Field(
        default=FrozenDict({"success": "success", "failure": "failure"}), min_length=1
    )
    codes: tuple[str, ...] = ()
    """Failure codes that it may end with, for completion and checking of `failure.<code>` edges."""
    settings: FrozenDict[str, Value] = FrozenDict()
    """Fixed values that the implementation is made with, for nodes that are generated from one class."""
    resume: Literal["resume", "restart", "ask"] | None = None
    """What is done about an activation of a process that died: the leaf's own `resume`, a new start, or a question.

    Without it: nodes that move something or ask somebody else, and nodes of projects, are asked about; others restart.
    """
    moves: bool | None = None
    """Whether its work may move something, so that it has to have ended, or been stopped, before another begins.

    Without it: built-in nodes of arms and hands, nodes that ask somebody else, and nodes of projects may.
    """
    kind: Literal["leaf"] = "leaf"

    @model_validator(mode="after")
    def _codes_are_of_failures(self) -> Manifest:
        if self.codes and "failure" not in self.outcomes.values():
            raise ValueError("`codes` are those of failures, and no outcome means failure: add one, or remove `codes`")
        return self

    @model_validator(mode="after")
    def _outputs_are_of_outcomes(self) -> Manifest:
        for name, port in self.outputs.items():
            for outcome in port.on:
                if outcome not in self.outcomes:
                    hint, allowed = nearest(outcome, self.outcomes), listing(self.outcomes)
                    raise ValueError(f"outputs/{name}: unknown outcome {outcome!r}{hint} (available: {allowed})")
        return self

    @property
    def may_move(self) -> bool:
        """Whether its work may move something; see `moves`."""
        return self.outside if self.moves is None else self.moves

    @property
    def outside(self) -> bool:
        """Whether its work reaches beyond this process: it moves a robot, asks somebody else, or is a project's own."""
        return self.id.partition("/")[0] in MOVES or not self.implementation.startswith("grip_bt.")

    def outcomes_for(self, meaning: dict[str, Meaning]) -> dict[str, Meaning]:
        """Return the outcomes with a task's own `meaning` applied."""
        return {**self.outcomes, **{k: v for k, v in meaning.items() if k in self.outcomes}}


def read_manifests(path: Path | str) -> list[Manifest]:
    """Read the manifests of a file.

    An `implementation` in a Python file (`leaf.py:Class`) is relative to the manifest's folder; it is returned with the
    file's absolute path, so that a manifest alone says where its leaf is.

    Raises:
        DocumentError: a manifest is wrong, with the place of the first fault and a list of the others.
    """
    source = str(path)
    tree = parse(read_file(path), source)
    manifests = []
    for each in [entry.value for entry in tree.entries] if isinstance(tree, YamlList) else [tree]:
        if not isinstance(each, YamlMapping):
            message = "a manifest is a mapping with `id:`, `doc:` and `implementation:`"
            raise DocumentError(message, source, each.line, each.column)
        manifest, faults = check_model(each, Manifest, "a manifest")
        if manifest is None:
            raise document_error(faults, source)
        where, _, name = manifest.implementation.rpartition(":")
        if where.endswith(".py") and not Path(where).is_absolute():
            file = Path(path).resolve().parent / where
            manifest = manifest.model_copy(update={"implementation": f"{file}:{name}"})
        manifests.append(manifest)
    return manifests


def find_manifests(folder: Path | str) -> list[Manifest]:
    """Read every `manifest.yaml` in a folder and below it, in the order of their paths.

    Raises:
        DocumentError: a manifest is wrong.
    """
    files = sorted(Path(folder).glob("**/manifest.yaml"))
    return [manifest for file in files for manifest in read_manifests(file)]


def manifest_text(manifest: Manifest, header: str) -> str:
    """Return the file `manifest.yaml` as a person would write it: without what is default, in a fixed order."""
    dumped = manifest.model_dump(exclude_defaults=True)
    for name, parameter in manifest.parameters.items():
        if not parameter.required:
            dumped["parameters"][name]["default"] = parameter.default  # null too: else it would have to be given
    keys = ("parameters", "inputs", "outputs", "outcomes", "codes", "moves", "settings")
    given = {key: dumped.get(key) for key in keys if key in dumped or key == "outcomes"}
    data = {"id": manifest.id, "doc": manifest.doc, "implementation": manifest.implementation, **given}
    data["outcomes"] = dict(manifest.outcomes)
    tree = from_data(data)
    assert isinstance(tree, YamlMapping)
    blocks = {id(tree.entries[key].value) for key in ("parameters", "inputs", "outputs", "settings") if key in data}
    return header + write(tree, lambda part: id(part) in blocks)
