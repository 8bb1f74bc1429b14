"""What the XML dialects of behaviour trees share, in and out.

Reading takes XML of anybody: no entities, no document types, bounded in size and depth, with lines for messages.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat
from xml.sax.saxutils import escape, quoteattr

from grip_bt.base.errors import DocumentError, NotExpressibleError, listing
from grip_bt.compilers.resolve import Part
from grip_bt.task import model

LARGEST, DEEPEST = 4_000_000, 120
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
        """Return the one element inside.

        Raises:
            DocumentError: there isn't exactly one.
        """
        if len(self.children) != 1:
            raise self.error(f"needs one node inside, and has {len(self.children)}")
        return self.children[0]


def read_elements(text: str, source: str) -> Element:
    """Return the root element of a document.

    Raises:
        DocumentError: it isn't well-formed, has a document type, or is too large or too deep.
    """
    if len(text) > LARGEST:
        raise DocumentError(f"larger than {LARGEST // 1_000_000} MB", source)
    top = Element("", {}, 0)
    stack = [top]
    parser = expat.ParserCreate()

    def start(tag: str, attributes: dict[str, str]) -> None:
        if len(stack) > DEEPEST:
            raise DocumentError(f"nested deeper than {DEEPEST} levels", source, parser.CurrentLineNumber)
        element = Element(tag, attributes, parser.CurrentLineNumber, source)
        stack[-1].children.append(element)
        stack.append(element)

    def end(tag: str) -> None:
        stack.pop()

    def characters(text: str) -> None:
        stack[-1].text += text

    def refuse(*what: object) -> None:
        raise DocumentError("a document type (<!DOCTYPE ...>) isn't read; remove it", source, parser.CurrentLineNumber)

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.StartDoctypeDeclHandler = refuse
    parser.CharacterDataHandler, parser.buffer_text = characters, True
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        message = f"not well-formed XML: {expat.ErrorString(error.code)}"
        raise DocumentError(message, source, error.lineno, error.offset + 1) from None
    return top.children[0]


class TreeFiles:
    """The trees of a file and of those that it includes, by their ID.

    Args:
        folder: where it lies; without it, included files are refused.
        bound: the folder that included files have to lie in; `folder` by default.
    """

    include_tags: tuple[str, ...] = ("include", "import")
    path_attributes: tuple[str, ...] = ("src", "file")

    def __init__(self, source: str, folder: Path | None, bound: Path | None = None):
        self.source, self.folder, self.bound = source, folder, bound or folder
        self.trees: dict[str, Element] = {}
        self._seen: set[Path] = set()

    def load(self, text: str) -> str:
        """Take in the trees of a file; return the ID of the main one.

        Raises:
            DocumentError: a file can't be read, or there is no main tree.
        """
        root = read_elements(text, self.source)
        self._take(root, self.folder)
        if not self.trees:
            raise root.error("there is no <BehaviorTree>")
        main = root.attributes.get("main_tree_to_execute")
        if main is None and len(self.trees) == 1:
            main = next(iter(self.trees))
        if main is None or main not in self.trees:
            what = "no `main_tree_to_execute`" if main is None else f"no <BehaviorTree ID={main!r}>"
            raise root.error(f"{what} (available: {listing(self.trees)})")
        return main

    def check_root(self, root: Element) -> None:
        """Refuse a file of another format."""

    def take_model(self, element: Element) -> None:
        """Take in one entry of a TreeNodesModel."""

    def name_of(self, tree: Element) -> str:
        """Return the ID of a tree; empty where it has none."""
        return tree.attributes.get("ID", "")

    def _take(self, root: Element, folder: Path | None) -> None:
        self.check_root(root)
        for element in root.children:
            if element.tag == "BehaviorTree":
                name = self.name_of(element)
                if not name or name in self.trees:
                    raise element.error("needs an `ID` of its own")
                self.trees[name] = element
            elif element.tag == "TreeNodesModel":
                for entry in element.children:
                    self.take_model(entry)
            elif element.tag.lower() in self.include_tags:
                self._include(element, folder)
            else:
                raise element.error("isn't <BehaviorTree>, <TreeNodesModel> or <include>")

    def _include(self, element: Element, folder: Path | None) -> None:
        if package := element.attributes.get("ros_pkg"):
            raise element.error(
                f"ROS packages are not searched for included files ({package!r}); copy the file next to this one and"
                " remove `ros_pkg`"
            )
        said = next((element.attributes[name] for name in self.path_attributes if name in element.attributes), "")
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
        self._take(read_elements(text, str(file)), file.parent)


def comment(text: str, depth: int) -> list[str]:
    """Return a text as the lines of a comment; none for an empty one."""
    said = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    while "--" in said:
        said = said.replace("--", "- -")
    return [f"{'  ' * depth}<!-- {escape(said)} -->"] if said else []


def element_lines(
    part: Part, depth: int, describe: Callable[[Part], tuple[str, Mapping[str, str]]], comments: bool = False
) -> Iterator[str]:
    """Yield the lines of a node and of all below it; `describe` gives the tag and the attributes of one."""
    tag, attributes = describe(part)
    if comments:
        yield from comment(part.node.doc, depth)
    start = "  " * depth + f"<{tag}" + "".join(f" {key}={quoteattr(value)}" for key, value in attributes.items())
    if not part.children:
        yield f"{start}/>"
        return
    yield f"{start}>"
    for child in part.children:
        yield from element_lines(child, depth + 1, describe, comments)
    yield f"{'  ' * depth}</{tag}>"


def leaf_attributes(part: Part, node: model.Leaf, to_text: Callable[[object, str], str], target: str) -> dict[str, str]:
    """Return the parameters and ports of a leaf as attributes.

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
        if attributes.get(port, f"{{{variable}}}") != f"{{{variable}}}":
            raise NotExpressibleError(part.path, f"{port!r}, which is more than one port or parameter,", target)
        attributes[port] = f"{{{variable}}}"
    if {"name", "ID"} & set(attributes):
        raise NotExpressibleError(part.path, "a port or parameter called `name` or `ID`", target)
    return attributes
