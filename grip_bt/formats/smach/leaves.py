"""Leaves that run legacy states: what their outcomes mean, their manifests, and the source of their classes."""

from __future__ import annotations

import ast
import keyword
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from grip_bt.formats.imported import generated_by, manifests_text
from grip_bt.formats.names import free
from grip_bt.nodes.smach_leaf import task_name
from grip_bt.task import FrozenDict, Meaning
from grip_bt.task.catalog import Manifest
from grip_bt.task.catalog.manifest import InputPort, OutputPort, Parameter

from .reader.found import ContainerInfo, StateInfo
from .reader.names import MODULE

_SUCCESS = frozenset(
    (
        *("succeeded", "succeed", "success", "successful", "successfully", "done", "true", "valid", "finished"),
        *("finish", "arrived", "ok", "okay", "yes", "complete", "completed", "found", "reached", "exhausted"),
    )
)


def meaning_of(label: str) -> Meaning:
    """Return what an outcome of this name means."""
    return "success" if label.strip().lower() in _SUCCESS else "failure"


MARK = generated_by("smach")
NEXT_ITEM, OBEYED, COPY = "next_item", "preempt_obeyed", "copy"

First = Mapping[str, tuple[str, str]]


@dataclass(frozen=True)
class LeafSpec:
    """One kind of leaf; `cls` is its class in `leaves.py`, empty for one of GRIP's own.

    `source` is what its `make` returns; empty with `why` where a person has to say. `first`: input -> its variable, and
    the source of its value while that is unwritten.
    """

    manifest: Manifest
    cls: str
    source: str = ""
    why: str = ""
    first: First = field(default_factory=dict)
    where: str = ""


class Leaves:
    """The leaves of one legacy file."""

    def __init__(self, file: Path):
        self.file = file
        self.stem = task_name(file.stem).replace("-", "_").replace(" ", "_").strip("_").lower() or "legacy"
        self.specs: dict[object, LeafSpec] = {}
        self.modules: dict[Path, str] = {file: MODULE}

    def add(
        self, found: StateInfo, label: str, outcomes: list[str], keys: tuple[list[str], list[str]], first: First
    ) -> LeafSpec:
        """Return the leaf of a state; states that are made alike share one.

        Args:
            label: after which a state of a class of smach's own is called.
            keys: its input and output keys.
            first: values of unwritten inputs.
        """
        source = self.source(found)
        inputs, outputs = (tuple(dict.fromkeys(k)) for k in keys)
        key = (source or id(found), tuple(outcomes), inputs, outputs, tuple(sorted(first.items())))
        if key not in self.specs:
            cls = self._free(_class_name(label) if found.cls in ("", found.kind) else found.cls)
            every = tuple(task_name(o) for o in outcomes)
            manifest = Manifest(
                id=f"smach/{self.stem}/{cls}",
                doc=_doc(found),
                implementation=f"leaves.py:{cls}",
                parameters=FrozenDict({"unwritten": Parameter(type="list[str]", default=[])}),
                inputs=FrozenDict({k: InputPort(type="Any", required=False) for k in inputs}),
                outputs=FrozenDict({k: OutputPort(type="Any", on=every) for k in outputs}),
                outcomes=FrozenDict({label: meaning_of(label) for label in every}),
            )
            self.specs[key] = LeafSpec(manifest, cls, source, found.why, first, str(found.span))
        return self.specs[key]

    def next_item(self) -> LeafSpec:
        """Return the leaf that hands out the items of an iteration."""
        parameters = {"items": Parameter(type="list"), "leaves_by": Parameter(type="str", default="")}
        means: dict[str, Meaning] = {"item": "success", "exhausted": "failure", "preempted": "failure"}
        ports = {"position": OutputPort(type="int", on=tuple(means)), "item": OutputPort(type="Any", on=("item",))}
        return self._ours(
            (NEXT_ITEM,),
            "NextItem",
            "The next item of an iteration.",
            parameters,
            means,
            {"position": InputPort(type="int")},
            ports,
        )

    def obeyed(self) -> LeafSpec:
        """Return the leaf that ends a Concurrence which was preempted."""
        doc, allowed = "Whether a preempt request was obeyed by all the others.", Parameter(type="bool", default=True)
        means: dict[str, Meaning] = {"others": "success", "preempted": "failure"}
        return self._ours((OBEYED,), "Obeyed", doc, {"allowed": allowed}, means)

    def copy(self, names: list[str]) -> LeafSpec:
        """Return the leaf that copies these keys into a container."""
        doc = f"Copy {', '.join(names)} into or out of a container."
        parameters = {"unwritten": Parameter(type="list[str]", default=[])}
        inputs = {k: InputPort(type="Any", required=False) for k in names}
        outputs = {k: OutputPort(type="Any", on=("done",)) for k in names}
        return self._ours((COPY, *names), "CopyKeys", doc, parameters, {"done": "success"}, inputs, outputs)

    def _ours(
        self,
        key: tuple[str, ...],
        cls: str,
        doc: str,
        parameters: Mapping[str, Parameter],
        outcomes: Mapping[str, Meaning],
        inputs: Mapping[str, InputPort] = FrozenDict(),
        outputs: Mapping[str, OutputPort] = FrozenDict(),
    ) -> LeafSpec:
        """Return a leaf whose class is GRIP's; keys that are copied make a leaf each."""
        if key not in self.specs:
            number = sum(isinstance(k, tuple) and k[0] == COPY for k in self.specs) + 1
            manifest = Manifest(
                id=f"smach/{self.stem}/{key[0]}" + (f"_{number}" if key[0] == COPY else ""),
                doc=doc,
                implementation=f"grip_bt.nodes.smach_leaf:{cls}",
                parameters=FrozenDict(parameters),
                inputs=FrozenDict(inputs),
                outputs=FrozenDict(outputs),
                outcomes=FrozenDict(outcomes),
            )
            self.specs[key] = LeafSpec(manifest, "")
        return self.specs[key]

    def _free(self, name: str) -> str:
        name = f"State{name}" if name.startswith(MODULE) else name
        return free(name, {*(spec.cls for spec in self.specs.values()), NEXT_ITEM, "Path", "SmachLeaf", "load_legacy"})

    def source(self, found: StateInfo) -> str:
        """Return the source that gives a legacy object; empty where nothing does."""
        filled = isinstance(found, ContainerInfo) and found.cls == found.kind  # its children are added later
        if found.expression is not None and not filled:
            return self.unparsed(found.expression, found.file or found.span.file)
        return self.live(found)

    def live(self, found: StateInfo) -> str:
        """Return the source that takes an object from the container that the legacy module builds."""
        labels: list[str] = []
        inner: object = found
        outer = found.parent
        while outer is not None:
            labels.append(next((name for name, added in outer.added.items() if added.state is inner), ""))
            inner, outer = outer, outer.parent
        if not isinstance(inner, ContainerInfo) or inner.entry is None or "" in labels:
            return ""
        entry = self.unparsed(inner.entry, inner.entry_file or inner.span.file)
        given = "".join(f", {name}={value!r}" for name, value in inner.entry_arguments.items())
        start = f"self.built({entry}{given})" if inner.entry_is_call else entry
        return start + "".join(f"[{label!r}]" for label in reversed(labels))

    def unparsed(self, expression: ast.expr, file: Path) -> str:
        """Return an expression as text, with the module of `file` under its name in `leaves.py`."""
        name = self.modules.setdefault(file, f"{MODULE}_{len(self.modules) + 1}")
        text = ast.unparse(expression)
        if name == MODULE:
            return text
        tree = ast.parse(text, mode="eval")
        for node in ast.walk(tree):
            if isinstance(node, ast.Name) and node.id == MODULE:
                node.id = name
        return ast.unparse(tree)

    def texts(self, folder: Path) -> dict[str, str]:
        """Return the files of the folder that holds these leaves."""
        header = f"# {MARK} from {self.file.name}; edits here are lost when it runs again.\n"
        manifests = manifests_text((spec.manifest for spec in self.specs.values()), header)
        return {"manifest.yaml": manifests, "leaves.py": self._python(folder)}

    def _python(self, folder: Path) -> str:
        lines = [
            f'"""The states of {self.file.name} as leaves. {MARK}; edits here are lost when it runs again."""',
            "",
            "from pathlib import Path",
            "",
            "from grip_bt.nodes.smach_leaf import SmachLeaf",
            "from grip_bt.nodes.smach_source import load_legacy",
            "",
            "HERE = Path(__file__).resolve().parent",
        ]
        for file, name in self.modules.items():
            relative = os.path.relpath(file.resolve(), folder.resolve())
            lines.append(f"{name} = load_legacy(HERE / {Path(relative).as_posix()!r})")
        firsts = {f"first_{v}": text for spec in self.specs.values() for v, text in spec.first.values()}
        for name, text in firsts.items():
            lines += ["", "", f"def {name}(self):", f"    return {text}"]
        for spec in self.specs.values():
            lines += _class(spec) if spec.cls else []
        return "\n".join(lines) + "\n"


def _class_name(label: str) -> str:
    """Return `PICK_UP` as `PickUp`."""
    words = [w for w in re.split(r"[^A-Za-z0-9]+", label) if w]
    name = "".join(w.capitalize() if w.isupper() or w.islower() else w[0].upper() + w[1:] for w in words)
    return name if name[:1].isalpha() and name.isidentifier() and not keyword.iskeyword(name) else f"State{name}"


def _class(spec: LeafSpec) -> list[str]:
    lines = ["", "", f"class {spec.cls}(SmachLeaf):", f'    """{spec.manifest.doc}"""', ""]
    if spec.first:
        pairs = ", ".join(f"{key!r}: first_{variable}" for key, (variable, _) in spec.first.items())
        lines += [f"    first = {{{pairs}}}", ""]
    lines.append("    def make(self):")
    if spec.source:
        return [*lines, f"        return {spec.source}"]
    return [*lines, f"        raise NotImplementedError({f'{spec.where}: {spec.why}; return the state here'!r})"]


def _doc(found: StateInfo) -> str:
    base = f", a {found.kind}," if found.kind and found.kind != found.cls else ""
    return f"{found.cls}{base} of {found.span.file.name}:{found.span.line}".replace(",  of", " of")
