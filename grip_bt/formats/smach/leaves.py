"""Leaves that run legacy states: what their outcomes mean, their manifests, and the source of their classes."""

from __future__ import annotations

import keyword
import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from grip_bt.formats.imported import generated_by, manifests_text
from grip_bt.formats.names import free
from grip_bt.nodes.dry_run import good_outcomes, says_success
from grip_bt.nodes.smach_leaf import task_name
from grip_bt.task import FrozenDict, Meaning
from grip_bt.task.catalog import Manifest
from grip_bt.task.catalog.manifest import InputPort, OutputPort, Parameter

from .found import ContainerInfo, StateInfo, Way

MODULE = "legacy"
"""How generated code calls the file that it comes from."""


class Meanings:
    """What outcomes mean: by their names, or because they are among `success`.

    Of outcomes of which none is called after success, the first that isn't called after failure is it (`outcome4`).
    """

    def __init__(self, success: Iterable[str] = ()):
        self.success = frozenset(success)

    def of(self, outcomes: Iterable[str]) -> dict[str, Meaning]:
        """Return outcome -> what it means among these."""
        labels = list(outcomes)
        good = {o for o in labels if o in self.success} or good_outcomes(labels)
        return {o: "success" if o in good else "failure" for o in labels}

    def guessed(self, outcomes: Iterable[str]) -> str:
        """Return the outcome that was taken for success, though nothing says so; empty where there is none."""
        means = self.of(outcomes)
        good = [o for o, meaning in means.items() if meaning == "success"]
        return "" if not good or good[0] in self.success or says_success(good[0]) else good[0]


MARK = generated_by("smach")
COPY = "copy"

First = Mapping[str, tuple[str, str]]


@dataclass(frozen=True)
class LeafSpec:
    """One kind of leaf: its class in `leaves.py`, if any, what its `make` returns, input -> (variable, first value)."""

    manifest: Manifest
    cls: str
    source: str = ""
    first: First = field(default_factory=dict)


class Leaves:
    """The leaves of one legacy file."""

    def __init__(self, file: Path, meanings: Meanings | None = None):
        self.file, self.meanings = file, meanings or Meanings()
        self.stem = task_name(file.stem).replace("-", "_").replace(" ", "_").strip("_").lower() or "legacy"
        self.specs: dict[object, LeafSpec] = {}
        self.ways: dict[Way, str] = {}

    def add(
        self, found: StateInfo, label: str, outcomes: list[str], keys: tuple[list[str], list[str]], first: First
    ) -> LeafSpec:
        """Return the leaf of a state; states that are made alike share one.

        One of a class of smach's own is called after `label`; `keys` are its input and output keys.
        """
        source = self.source(found)
        inputs, outputs = (tuple(dict.fromkeys(k)) for k in keys)
        key = (source, tuple(outcomes), inputs, outputs, tuple(sorted(first.items())))
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
                outcomes=FrozenDict(dict(zip(every, self.meanings.of(outcomes).values(), strict=True))),
            )
            self.specs[key] = LeafSpec(manifest, cls, source, first)
        return self.specs[key]

    def copy(self, names: list[str]) -> LeafSpec:
        """Return the leaf that copies these keys into or out of a container."""
        number = sum(isinstance(key, tuple) and key[0] == COPY for key in self.specs) + 1
        said = {
            "id": f"smach/{self.stem}/{COPY}_{number}",
            "implementation": "grip_bt.nodes.smach_leaf:CopyKeys",
            "doc": f"Copy {', '.join(names)} into or out of a container.",
            "parameters": {"unwritten": {"type": "list[str]", "default": []}},
            "inputs": {name: {"type": "Any", "required": False} for name in names},
            "outputs": {name: {"type": "Any", "on": ["done"]} for name in names},
            "outcomes": {"done": "success"},
        }
        return self.specs.setdefault((COPY, *names), LeafSpec(Manifest.model_validate(said), ""))

    def _free(self, name: str) -> str:
        name = f"State{name}" if name.startswith(MODULE) else name
        return free(name, {*(s.cls for s in self.specs.values()), "Path", "SmachLeaf", "load_legacy", "built_in"})

    def source(self, found: StateInfo) -> str:
        """Return the source that takes an object from the machine that its file builds; empty where nothing does."""
        labels: list[str | None] = []
        inner: StateInfo = found
        while inner.parent is not None:
            labels.append(next((name for name, added in inner.parent.added.items() if added.state is inner), None))
            inner = inner.parent
        if not isinstance(inner, ContainerInfo) or inner.way is None or None in labels:
            return ""
        return self._machine(inner.way) + "".join(f"[{label!r}]" for label in reversed(labels))

    def _machine(self, way: Way) -> str:
        """Return the source of a machine: built by what has a name, or by a function of ours that is added."""
        if not way.called and way.returned:
            return f"{MODULE}.{way.builder}"
        if way.returned and not way.missing and "." not in way.builder and way.builder != "__main__":
            return f"self.built({', '.join(filter(None, (f'{MODULE}.{way.builder}', *way.calls)))})"
        return f"self.built({self.ways.setdefault(way, f'machine_{len(self.ways) + 1}')})"

    def texts(self, folder: Path) -> dict[str, str]:
        """Return the files of the folder that holds these leaves."""
        header = f"# {MARK} from {self.file.name}; edits here are lost when it runs again.\n"
        manifests = manifests_text((spec.manifest for spec in self.specs.values()), header)
        return {"manifest.yaml": manifests, "leaves.py": self._python(folder)}

    def _python(self, folder: Path) -> str:
        body = list[str]()
        for way, name in self.ways.items():
            body += ["", "", f"def {name}():", f"    return {_built(way, folder)}"]
        firsts = {f"first_{v}": text for spec in self.specs.values() for v, text in spec.first.values()}
        for name, text in firsts.items():
            body += ["", "", f"def {name}(self):", f"    return {text}"]
        for spec in self.specs.values():
            body += _class(spec) if spec.cls else []
        path = Path(os.path.relpath(self.file.resolve(), folder.resolve())).as_posix()
        lines = [
            f'"""The states of {self.file.name} as leaves. {MARK}; edits here are lost when it runs again."""',
            "",
            "from pathlib import Path",
            "",
            *(["from grip_bt.nodes.smach_construction import built_in, run_as_main"] if self.ways else []),
            f"from grip_bt.nodes.smach_leaf import SmachLeaf{', argument' if self.ways else ''}",
            "from grip_bt.nodes.smach_source import load_legacy",
            "",
            "HERE = Path(__file__).resolve().parent",
        ]
        if any(re.match(rf" +return .*(?<=[ (]){MODULE}\.", line) for line in body):
            lines.append(f"{MODULE} = load_legacy(HERE / {path!r})")
        return "\n".join([*lines, *body]) + "\n"


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
    return [*lines, "    def make(self):", f"        return {spec.source}"]


def _built(way: Way, folder: Path) -> str:
    """Return the source that builds a machine again, as it was when it was recorded."""
    (made, given), (cls, _, method) = ("", "", *way.calls)[-2:], way.builder.partition(".")
    called = f"{MODULE}.{way.builder}({given})" if not method else f"{MODULE}.{cls}({made}).{method}({given})"
    if way.returned:
        return called
    path = Path(os.path.relpath(way.file.resolve(), folder.resolve())).as_posix()
    code = f"run_as_main(HERE / {path!r})" if way.builder == "__main__" else f"lambda: {called}"
    return f"built_in(HERE / {path!r}, {way.line}, {code}{f', {way.number}' if way.number else ''})"


def _doc(found: StateInfo) -> str:
    base = f", a {found.kind}," if found.kind and found.kind != found.cls else ""
    return f"{found.cls}{base} of {found.span.file.name}:{found.span.line}".replace(",  of", " of")
