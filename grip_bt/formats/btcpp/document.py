"""The trees and models of a file and of those that it includes."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from grip_bt.base.errors import DocumentError, listing

from ..pytrees_xml.elements import LARGEST, Element, read_elements

_DIRECTIONS = {"input_port": "in", "output_port": "out", "inout_port": "inout"}


@dataclass(frozen=True)
class Port:
    """A port as a TreeNodesModel says it.

    Attributes:
        direction: `in`, `out` or `inout`.
        type: as it is written; empty where it isn't.
        default: what it is without an attribute, or None.
        doc: its text.
    """

    direction: str
    type: str = ""
    default: str | None = None
    doc: str = ""


@dataclass(frozen=True)
class Model:
    """A node type as a TreeNodesModel says it; `kind` is `Action`, `Condition`, `Control`, `Decorator` or `SubTree`."""

    kind: str
    ports: dict[str, Port] = field(default_factory=dict)


@dataclass(frozen=True)
class Place:
    """An element, and the file that it stands in."""

    element: Element
    source: str


@dataclass
class Document:
    """What the files say.

    Attributes:
        source: the main file, as messages call it.
        trees: by ID.
        models: by ID.
        remarks: what to know about the file.
    """

    source: str
    trees: dict[str, Place] = field(default_factory=dict)
    models: dict[str, Model] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)


def read_document(text: str, source: str, folder: Path | None, bound: Path | None) -> tuple[Document, str]:
    """Return what a file and its includes say, and the ID of the main tree.

    Args:
        text: the file.
        source: what to call it in messages.
        folder: where it lies; without it, includes are refused.
        bound: the folder that included files have to lie in.

    Raises:
        DocumentError: a file can't be read, or isn't of BT.CPP 4.
    """
    document = Document(source)
    root = read_elements(text, source)
    _check_format(root, document)
    _Reader(document, bound.resolve() if bound is not None else None).take(root, source, folder)
    if not document.trees:
        raise root.error("there is no <BehaviorTree>", source)
    main = root.attributes.get("main_tree_to_execute")
    if main is None and len(document.trees) == 1:
        main = next(iter(document.trees))
    if main is None or main not in document.trees:
        what = "no `main_tree_to_execute`" if main is None else f"no <BehaviorTree ID={main!r}>"
        raise root.error(f"{what} (there are: {listing(document.trees)})", source)
    return document, main


def _check_format(root: Element, document: Document) -> None:
    said = root.attributes.get("BTCPP_format")
    if root.tag != "root":
        raise root.error('a file of BT.CPP begins with <root BTCPP_format="4">', document.source)
    if said is not None and said.split(".")[0] != "4":
        raise root.error(
            f"BTCPP_format is {said}, and 4 is read; BT.CPP's convert_v3_to_v4.py makes one", document.source
        )
    if said is None:
        document.remarks.append('<root> has no BTCPP_format="4"; it was read as if it had')


class _Reader:
    def __init__(self, document: Document, bound: Path | None):
        self.document, self.bound = document, bound
        self.seen: set[Path] = set()

    def take(self, root: Element, source: str, folder: Path | None) -> None:
        for element in root.children:
            if element.tag == "BehaviorTree":
                self._tree(element, source)
            elif element.tag == "TreeNodesModel":
                for model in element.children:
                    self._model(model, source)
            elif element.tag.lower() == "include":
                self._include(element, source, folder)
            else:
                raise element.error("isn't <BehaviorTree>, <TreeNodesModel> or <include>", source)

    def _tree(self, element: Element, source: str) -> None:
        trees = self.document.trees
        name = element.attributes.get("ID") or ("BehaviorTree" if not trees else "")
        if not name or name in trees:
            raise element.error("needs an `ID` of its own", source)
        trees[name] = Place(element, source)

    def _model(self, element: Element, source: str) -> None:
        name = element.attributes.get("ID", "")
        if not name:
            raise element.error("needs an `ID`", source)
        ports: dict[str, Port] = {}
        for port in element.children:
            direction = _DIRECTIONS.get(port.tag)
            if direction is not None and port.attributes.get("name"):
                said = port.attributes
                ports[said["name"]] = Port(direction, said.get("type", ""), said.get("default"), port.text.strip())
        self.document.models[name] = Model(element.tag, ports)

    def _include(self, element: Element, source: str, folder: Path | None) -> None:
        if "ros_pkg" in element.attributes:
            package = element.attributes["ros_pkg"]
            raise element.error(
                f"the file lies in the ROS package {package!r}, which isn't looked for; copy it beside this file and"
                " remove `ros_pkg`",
                source,
            )
        said = element.attributes.get("path", "")
        file = (folder / said).resolve() if folder is not None else None
        if file is None or self.bound is None or not file.is_relative_to(self.bound) or not file.is_file():
            raise element.error(f"there is no file {said!r} in the folder of this one, or of its project", source)
        if file in self.seen:
            return
        self.seen.add(file)
        try:
            if file.stat().st_size > LARGEST:
                raise DocumentError(f"larger than {LARGEST // 1_000_000} MB", str(file))
            text = file.read_text(encoding="utf-8", errors="replace")
        except OSError as error:
            raise element.error(f"{said!r} can't be read: {error.strerror or error}", source) from error
        root = read_elements(text, str(file))
        _check_format(root, self.document)
        self.take(root, str(file), file.parent)
