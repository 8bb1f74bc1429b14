"""What the XML dialects of behaviour trees share, in and out.

Reading takes XML of anybody, bounded in size.
"""

from __future__ import annotations

import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import cast
from xml.sax.saxutils import escape, unescape

from grip_bt.base.errors import DocumentError, NotExpressibleError, listing, nearest
from grip_bt.base.xml import MalformedError, XmlElement, parse_xml
from grip_bt.commanders.description.packages import name_of_package
from grip_bt.compilers.resolve import Part
from grip_bt.formats.imported import Issues
from grip_bt.formats.names import free
from grip_bt.task import model

LARGEST, DEEPEST, MOST_FILES = 4_000_000, 120, 100_000
MOST_NODES = 20_000
"""Of one task; sub-trees within sub-trees could make any number of a small file."""


@dataclass
class Element:
    """One element with its place; comments in it are left out."""

    tag: str
    attributes: dict[str, str]
    line: int
    source: str = ""
    children: list[Element] = field(default_factory=list)
    text: str = ""

    def __str__(self) -> str:
        name = self.attributes.get("name") or self.attributes.get("ID")
        return f"<{self.tag}>" if name is None else f"<{self.tag}> {name!r}"

    def error(self, message: str) -> DocumentError:
        """Return an error that names this element and its place."""
        return DocumentError(f"{self}: {message}", self.source, self.line)

    def only_child(self) -> Element:
        """Return the one element inside. Raises DocumentError: there isn't exactly one."""
        if len(self.children) != 1:
            raise self.error(f"needs one node inside, and has {len(self.children)}")
        return self.children[0]


_ATTRIBUTE = re.compile(r"""(=\s*)("[^"]*"|'[^']*')""")
_ROOT = re.compile(r"<root\b.*</root\s*>|<root\b.*", re.S)
_NO_ENTITY = re.compile(r"&(?!(?:amp|lt|gt|quot|apos|#\d+|#x[0-9a-fA-F]+);)")


def mended(text: str) -> str:
    """Return a document as TinyXML2 reads it: `&` and `<` in values are text, what is around the root is nothing."""

    def value(found: re.Match[str]) -> str:
        return found.group(1) + found.group(2).replace("<", "&lt;")

    whole = _ROOT.search(text)
    if whole is None:
        return text
    lines = "\n" * text[: whole.start()].count("\n")
    return lines + _ATTRIBUTE.sub(value, _NO_ENTITY.sub("&amp;", whole.group()))


def read_elements(text: str, source: str, lenient: bool = False) -> Element:
    """Return the root element of a document.

    Args:
        lenient: whether it is read as TinyXML2 does where it isn't well-formed.

    Raises:
        DocumentError: it isn't well-formed, declares an entity, or is too large or too deep.
    """
    if len(text) > LARGEST:
        raise DocumentError(f"larger than {LARGEST // 1_000_000} MB", source)
    try:
        return _element(parse_xml(text, source, DEEPEST), source)
    except MalformedError:
        if lenient and (again := mended(text)) != text:
            return read_elements(again, source)
        raise


def _element(found: XmlElement, source: str) -> Element:
    text = (found.text or "") + "".join(each.tail or "" for each in found)
    inside = [_element(each, source) for each in found]  # type: ignore[arg-type]
    return Element(found.tag, found.attrib, found.line or 0, source, inside, text)


_DIRECTIONS = {"input_port": "in", "output_port": "out", "inout_port": "inout", "bidirectional_port": "inout"}


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


class Document:
    """What a file and its includes say: trees and models by ID, and what to know about the file.

    Args:
        folder: where it lies; without it, included files are refused.
        bound: the folder that included files have to lie in; `folder` by default.
        library: where trees and packages are looked for that the file doesn't have.
        btcpp: whether it is BehaviorTree.CPP's, of version 4, and read as TinyXML2 does.
    """

    def __init__(
        self,
        source: str,
        folder: Path | None,
        bound: Path | None = None,
        library: Library | None = None,
        btcpp: bool = True,
    ):
        self.source, self.folder, self.bound, self.library = source, folder, bound or folder, library
        self.trees: dict[str, Element] = {}
        self.models: dict[str, Model] = {}
        self.issues = Issues(source)
        self._btcpp = btcpp
        self._seen: set[Path] = set()

    def load(self, text: str) -> str:
        """Take in the trees of a file; return the ID of the main one. Raises DocumentError: there is none."""
        root = self.take_text(text)
        mains = self.mains(root)
        if len(mains) != 1:
            raise root.error(f"no `main_tree_to_execute`, and several could be it (available: {listing(mains)})")
        return mains[0]

    def take_text(self, text: str) -> Element:
        """Take in the trees of a file; return its root element."""
        root = read_elements(text, self.source, self._btcpp)
        self._take(root, self.folder)
        return root

    def mains(self, root: Element) -> list[str]:
        """Return the ID of the main tree, or of each that no other one holds. Raises DocumentError: there is none."""
        if not self.trees:
            raise root.error("there is no <BehaviorTree>")
        main = root.attributes.get("main_tree_to_execute")
        if main is not None and main not in self.trees:
            raise root.error(f"no <BehaviorTree ID={main!r}> (available: {listing(self.trees)})")
        own = [self._name_of(each) for each in root.children if each.tag == "BehaviorTree"]
        used = {name for tree in self.trees.values() for name in subtrees_of(tree)}
        return [main] if main is not None else [n for n in own if n in self.trees and n not in used] or list(self.trees)

    def tree(self, name: str, user: Element) -> Element | None:
        """Return a tree by its ID, also where only another file beside those that were read has it."""
        if name not in self.trees and self.library is not None:
            near = Path(user.source) if user.source else None
            files = self.library.files(name, near)
            for file in files[:1]:
                others = f"; {len(files) - 1} other files have one of that name" if files[1:] else ""
                text = f"was found in {file}{others}"
                self.issues.add("changed", f"<BehaviorTree> {name!r}", text, self.source)
                self._take(read_elements(self.library.text(file), str(file), self._btcpp), file.parent, ours=False)
        return self.trees.get(name)

    def wanted(self, root: Element, name: str) -> str:
        """Return the name of a tree that is asked for. Raises DocumentError: there is none of that name."""
        if self.tree(name, root) is None:
            there = f"{nearest(name, self.trees)} (available: {listing(self.trees)})"
            raise DocumentError(f"there is no tree {name!r}{there}", self.source)
        return name

    def take_models(self, text: str, path: Path) -> None:
        """Take in the models of a file that nobody includes; what can't be read is left alone."""
        try:
            self._take(read_elements(text, str(path), self._btcpp), path.parent, ours=False)
        except DocumentError:
            self.issues.add("left-out", path.name, "can't be read, and its models weren't")

    def _check_root(self, root: Element) -> None:
        """Refuse a file of another version than 4."""
        said = root.attributes.get("BTCPP_format")
        if root.tag != "root":
            raise root.error('a file of BehaviorTree.CPP begins with <root BTCPP_format="4">')
        if said is not None and said.split(".")[0] != "4":
            raise root.error(f"BTCPP_format is {said}, and 4 is read; BT.CPP's convert_v3_to_v4.py makes one")
        if said is None:
            self._note("changed", root, 'has no BTCPP_format="4"; it was read as if it had')

    def _note(self, code: str, element: Element, text: str) -> None:
        self.issues.add(code, str(element), text, element.source, element.line)

    def _take_model(self, element: Element) -> None:
        name = element.attributes.get("ID", "")
        ports: dict[str, Port] = {}
        for port in element.children:
            said = port.attributes
            if port.tag in _DIRECTIONS and said.get("name"):
                direction = _DIRECTIONS[port.tag]
                ports[said["name"]] = Port(direction, said.get("type", ""), said.get("default"), port.text.strip())
        if name:
            before = self.models.get(name, Model(""))
            self.models[name] = Model(element.tag, {**before.ports, **ports})

    def _name_of(self, tree: Element) -> str:
        """Return the ID of a tree, which needs none."""
        return tree.attributes.get("ID") or free("BehaviorTree", self.trees)

    def _take(self, root: Element, folder: Path | None, ours: bool = True) -> None:
        if self._btcpp:
            self._check_root(root)
        for element in root.children:
            if element.tag == "BehaviorTree":
                name = self._name_of(element)
                if ours and (not name or name in self.trees):
                    raise element.error("needs an `ID` of its own")
                element.attributes["ID"] = name
                self.trees.setdefault(name, element)
            elif element.tag == "TreeNodesModel":
                for entry in element.children:
                    self._take_model(entry)
            elif element.tag.lower() in ("include", "import"):
                self._include(element, folder)
            else:
                text = "isn't <BehaviorTree>, <TreeNodesModel> or <include>, and was left out"
                self._note("left-out", element, text)

    def _include(self, element: Element, folder: Path | None) -> None:
        if package := element.attributes.get("ros_pkg"):
            home = self.library.package(package) if self.library is not None else None
            if home is None:
                raise element.error(f"there is no package {package!r} in the workspace (a folder with a package.xml)")
            folder = home
        said = next((element.attributes[k] for k in ("path", "src", "file") if k in element.attributes), "")
        file = (folder / said).resolve() if folder is not None else None
        inside = file is not None and self.bound is not None and file.is_relative_to(self.bound.resolve())
        if file is None or not inside or not file.is_file():
            raise element.error(f"there is no file {said!r} in the folder of this one, or of its project")
        if file in self._seen:
            return
        self._seen.add(file)
        try:
            if file.stat().st_size > LARGEST:
                raise DocumentError(f"larger than {LARGEST // 1_000_000} MB", str(file))
            text = file.read_text(encoding="utf-8", errors="replace")
        except OSError as error:
            raise element.error(f"{said!r} can't be read: {error.strerror or error}") from error
        self._take(read_elements(text, str(file), self._btcpp), file.parent)


_ID = re.compile(r"""<BehaviorTree\s[^>]*?\bID\s*=\s*(?:"([^"]*)"|'([^']*)')""")


def subtrees_of(tree: Element) -> Iterator[str]:
    """Yield the IDs of the trees that a tree holds."""
    stack = [tree]
    while stack:
        element = stack.pop()
        if element.tag == "SubTree":
            yield element.attributes.get("ID", "")
        stack.extend(element.children)


def workspace_of(path: Path) -> Path:
    """Return the outermost folder that a path belongs to: a repository, the packages of a workspace, or its own."""
    folder = path if path.is_dir() else path.parent
    around = [folder, *folder.parents]
    for home in around:
        if (home / ".git").exists():
            return home
    packages = [home for home in around if (home / "package.xml").is_file()]
    return packages[-1].parent if packages else folder


class Library:
    """The trees and packages of a workspace, read when a file names one that it doesn't have."""

    def __init__(self, root: Path):
        self.root = root

    @cached_property
    def _index(self) -> tuple[dict[str, list[Path]], dict[str, Path]]:
        trees: dict[str, list[Path]] = {}
        packages: dict[str, Path] = {}
        for path in xml_files(self.root):
            text = self.text(path)
            if path.name == "package.xml":
                packages.setdefault(name_of_package(path.parent), path.parent)
            for found in _ID.finditer(text):
                name = unescape(found.group(1) or found.group(2) or "")
                trees.setdefault(name, []).append(path)
        return trees, packages

    def files(self, name: str, near: Path | None) -> list[Path]:
        """Return the files that have a tree, the nearest to a file first."""
        there, home = dict.fromkeys(self._index[0].get(name, ())), near.parent if near is not None else self.root
        return sorted(there, key=lambda path: (len(Path(os.path.relpath(path, home)).parts), str(path)))

    def package(self, name: str) -> Path | None:
        """Return the folder of a ROS package."""
        return self._index[1].get(name)

    def text(self, path: Path) -> str:
        """Return the text of a file; nothing where it can't be read, or is too large."""
        try:
            return "" if path.stat().st_size > LARGEST else path.read_text(encoding="utf-8", errors="replace")
        except OSError:
            return ""


def xml_files(folder: Path) -> list[Path]:
    """Return the XML files of a folder and below it, in order, but for what is hidden or was built."""
    found: list[Path] = []
    seen = 0
    for home, folders, names in os.walk(folder):
        folders[:] = sorted(n for n in folders if n not in ("build", "install", "node_modules") and n[0] != ".")
        seen += len(names)
        found += [Path(home, name) for name in sorted(names) if name.lower().endswith(".xml")]
        if seen > MOST_FILES:
            break
    return found


def comment(text: str) -> list[ET.Element[str]]:
    """Return a text as a comment; none for an empty one."""
    said = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    while "--" in said:
        said = said.replace("--", "- -")
    return [cast("ET.Element[str]", ET.Comment(f" {escape(said)} "))] if said else []


def xml_element(
    part: Part, describe: Callable[[Part], tuple[str, dict[str, str]]], comments: bool = False
) -> ET.Element[str]:
    """Return a node with all below it; `describe` gives the tag and the attributes of one, `comments` have its doc."""
    made = ET.Element(*describe(part))
    for child in part.children:
        made.extend(comment(child.node.doc if comments else ""))
        made.append(xml_element(child, describe, comments))
    return made


def xml_text(root: ET.Element[str]) -> str:
    """Return a document, indented."""
    ET.indent(root, "  ")
    return ET.tostring(root, encoding="unicode") + "\n"


def require_expressible(path: str, node: model.AnyNode, fields: Collection[str] | None, target: str) -> None:
    """Refuse a node whose kind has no equivalent, or that says more than the format can.

    Args:
        fields: what the format can say of such a node; None where it has no equivalent.

    Raises:
        NotExpressibleError: it names the node and the field.
    """
    kind = getattr(node, "kind", "leaf")
    if fields is None:
        raise NotExpressibleError(path, f"a {kind}", target)
    for name, info in type(node).model_fields.items():
        if name not in (*fields, *_COMMON) and getattr(node, name) != info.get_default(call_default_factory=True):
            said = name if info.alias in (None, "*") else info.alias  # `*`: free data, whatever it is called
            raise NotExpressibleError(path, f"`{said}` of a {kind}", target)


_COMMON = ("doc", "kind", "children", "child")


def leaf_attributes(
    part: Part,
    node: model.Leaf,
    to_text: Callable[[object, str], str],
    target: str,
    key_of: Callable[[str], str] = str,
) -> dict[str, str]:
    """Return the parameters and ports of a leaf as attributes; `key_of` says how a variable is called there.

    Raises:
        NotExpressibleError: a value has no text, or a name stands for more than one port or parameter.
    """
    assert part.manifest is not None, "resolved leaves have a manifest"
    attributes: dict[str, str] = {}
    for name, value in node.with_.items():
        try:
            attributes[name] = to_text(value, part.manifest.parameters[name].type)
        except ValueError as error:
            raise NotExpressibleError(part.path, f"`{name}` ({error})", target) from error
    for port, variable in (*node.in_.items(), *node.out.items()):
        key = f"{{{key_of(variable)}}}"
        if attributes.setdefault(port, key) != key:
            raise NotExpressibleError(part.path, f"{port!r}, which is more than one port or parameter,", target)
    if {"name", "ID"} & set(attributes):
        raise NotExpressibleError(part.path, "a port or parameter called `name` or `ID`", target)
    return attributes
