"""How much of other people's BehaviorTree.CPP projects comes in: the importer over folders, as a table.

`python tools/btcpp_imports.py FOLDER...` takes every XML file of a folder that holds a tree, and every document in its
C++, Python and Markdown files; sub-trees, packages and models are looked for in the whole folder. `--list` names the
documents that didn't come in.
"""

from __future__ import annotations

import argparse
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from grip_bt.base.errors import GripError
from grip_bt.formats.btcpp.importer import Importer, settle
from grip_bt.formats.btcpp.leaves import Leaves
from grip_bt.formats.imported import ImportRefusedError
from grip_bt.formats.xml_trees import Document, Library
from grip_bt.task.catalog import Catalog
from grip_bt.task.validation import validate

_ROOT = re.compile(r"<root\b[^>]*>.*?</root>", re.DOTALL)
_OTHER = (".cpp", ".hpp", ".h", ".md", ".mdx", ".py")
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)


def documents(folder: Path) -> Iterator[tuple[str, str, Path]]:
    """Yield the name, the text and the file of every document."""
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        if path.suffix.lower() not in (".xml", *_OTHER):
            continue
        text = path.read_text(encoding="utf-8", errors="replace")
        if path.suffix.lower() == ".xml":
            if "<root" in text and "<BehaviorTree" in _COMMENT.sub("", text):
                yield str(path), text, path
            continue
        for number, found in enumerate(_ROOT.finditer(text)):
            said = found.group()
            if path.suffix == ".cpp" and ("\\n" in said or re.search(r'"\s*\n\s*R?"', said)):  # lines of literals
                said = re.sub(r'(?:\\n)?"\s*\n\s*R?"\(?', "\n", said).replace('\\"', '"').replace("\\n", "\n")
            if "<BehaviorTree" in said:
                yield f"{path}#{number}", said, path


def imported(name: str, text: str, path: Path, library: Library, catalog: Catalog) -> list[str]:
    """Return why a document doesn't come in as tasks that pass the checks; nothing where it does."""
    document = Document(name, path.resolve().parent, library.root, library)
    try:
        for main in document.mains(document.take_text(text)):
            importer = Importer(document, Leaves(catalog, document.models), main)
            settle([importer])
            importer.reading.issues.raise_if_refused(name)
            made = importer.result()
            report = validate(made.task, catalog.with_manifests(made.manifests))
            if report.errors:
                return [f"passes not every check: {issue.code}: {issue.message}" for issue in report.errors]
    except ImportRefusedError as error:
        return [f"{issue.path.split()[0]}: {issue.message}" for issue in error.issues]
    except GripError as error:
        return [str(error).removeprefix(name)]
    return []


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--list", action="store_true")
    args = parser.parse_args()
    catalog = Catalog.builtin()
    for folder in args.folders:
        library, every, well, causes = Library(folder.resolve()), 0, 0, Counter[str]()
        for name, text, path in documents(folder):
            every += 1
            wrong = imported(name, text, path, library, catalog)
            well += not wrong
            causes.update({cause[:140] for cause in wrong})
            if args.list and wrong:
                print(f"  {name}: {wrong[0]}")
        rate = f"{100 * well / every:.0f} %" if every else "none"
        print(f"{folder.name}: {well} of {every} documents ({rate})")
        for cause, times in causes.most_common(12):
            print(f"    {times} x {cause}")


if __name__ == "__main__":
    main()
