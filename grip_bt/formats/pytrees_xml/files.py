"""The trees of a file and of those that it includes."""

from __future__ import annotations

from pathlib import Path

from grip_bt.base.errors import listing

from .elements import Element, read_elements


class Files:
    """Trees by their ID.

    Args:
        source: what to call the file in messages.
        folder: where included files are looked for, and no further up; None refuses them.
    """

    def __init__(self, source: str, folder: Path | None):
        self.source, self.folder = source, folder.resolve() if folder is not None else None
        self.trees: dict[str, Element] = {}

    def load(self, root: Element) -> Element:
        """Take in the trees of a file and of those that it includes; return the main one."""
        self._take(root, self.folder, set())
        main = root.attributes.get("main_tree_to_execute")
        if main is None and len(self.trees) == 1:
            main = next(iter(self.trees))
        if main not in self.trees:
            what = "no `main_tree_to_execute`" if main is None else f"no <BehaviorTree ID={main!r}>"
            raise root.error(f"{what} (there are: {listing(self.trees)})", self.source)
        return self.trees[main]

    def _take(self, root: Element, folder: Path | None, seen: set[Path]) -> None:
        for element in root.children:
            if element.tag == "BehaviorTree":
                name = element.attributes.get("ID", "")
                if not name or name in self.trees:
                    raise element.error("needs an `ID` of its own", self.source)
                self.trees[name] = element
            elif element.tag.lower() in ("include", "import"):
                self._include(element, folder, seen)
            elif element.tag != "TreeNodesModel":
                raise element.error("isn't <BehaviorTree> or <Include>", self.source)

    def _include(self, element: Element, folder: Path | None, seen: set[Path]) -> None:
        said = element.attributes.get("src") or element.attributes.get("file") or ""
        file = (folder / said).resolve() if folder is not None else None
        if file is None or self.folder is None or not file.is_relative_to(self.folder) or not file.is_file():
            raise element.error(f"there is no file {said!r} in the folder of this one", self.source)
        if file not in seen:
            seen.add(file)
            text = file.read_text(encoding="utf-8", errors="replace")
            self._take(read_elements(text, str(file)), file.parent, seen)


def only_child(element: Element, source: str) -> Element:
    """Return the one element inside of another.

    Raises:
        DocumentError: there isn't exactly one.
    """
    if len(element.children) != 1:
        raise element.error(f"needs one element inside, and has {len(element.children)}", source)
    return element.children[0]
