"""The trees of a file of BehaviorTree.CPP and the node types that its TreeNodesModel declares."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from grip_bt.formats.imported import Issues
from grip_bt.formats.xml_trees import Element, TreeFiles

_DIRECTIONS = {"input_port": "in", "output_port": "out", "inout_port": "inout"}


@dataclass(frozen=True)
class Port:
    """A port as a TreeNodesModel says it; `direction` is `in`, `out` or `inout`."""

    direction: str
    type: str = ""
    default: str | None = None
    doc: str = ""


@dataclass(frozen=True)
class Model:
    """A node type as a TreeNodesModel says it; `kind` is `Action`, `Condition`, `Control`, `Decorator` or `SubTree`."""

    kind: str
    ports: dict[str, Port] = field(default_factory=dict)


class Document(TreeFiles):
    """What a file and its includes say: trees and models by ID, and what to know about the file."""

    include_tags = ("include",)
    path_attributes = ("path",)

    def __init__(self, source: str, folder: Path | None, bound: Path | None):
        super().__init__(source, folder, bound)
        self.models: dict[str, Model] = {}
        self.issues = Issues(source)

    def check_root(self, root: Element) -> None:
        """Refuse a file of another version than 4."""
        said = root.attributes.get("BTCPP_format")
        if root.tag != "root":
            raise root.error('a file of BehaviorTree.CPP begins with <root BTCPP_format="4">')
        if said is not None and said.split(".")[0] != "4":
            raise root.error(f"BTCPP_format is {said}, and 4 is read; BT.CPP's convert_v3_to_v4.py makes one")
        if said is None:
            text = 'has no BTCPP_format="4"; it was read as if it had'
            self.issues.add("changed", str(root), text, root.source, root.line)

    def name_of(self, tree: Element) -> str:
        """Return the ID of a tree; the first one needs none."""
        return tree.attributes.get("ID") or ("" if self.trees else "BehaviorTree")

    def take_model(self, element: Element) -> None:
        """Take in the ports of a node type."""
        name = element.attributes.get("ID", "")
        if not name:
            raise element.error("needs an `ID`")
        ports: dict[str, Port] = {}
        for port in element.children:
            direction = _DIRECTIONS.get(port.tag)
            if direction is not None and port.attributes.get("name"):
                said = port.attributes
                ports[said["name"]] = Port(direction, said.get("type", ""), said.get("default"), port.text.strip())
        self.models[name] = Model(element.tag, ports)
