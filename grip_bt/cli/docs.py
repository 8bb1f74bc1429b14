"""`grip docs`: the documentation, which comes built with an installed GRIP, in the browser; no network is needed."""

from __future__ import annotations

import argparse
import webbrowser
from pathlib import Path

import grip_bt
from grip_bt.base.errors import MissingPartError, UnknownNameError

_HOME = Path(grip_bt.__file__).parent
_SITES = (_HOME / "_docs", _HOME.parent / "build" / "site")
"""Where an installation has it, and where `make docs` builds it."""


def add_docs(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("page", nargs="?", default="index", metavar="PAGE", help="such as running, or nodes#arm")
    parser.add_argument("--no-browser", action="store_true", help="only print the address")


def run_docs(args: argparse.Namespace) -> None:
    site = next((folder for folder in _SITES if (folder / "index.html").is_file()), None)
    if site is None:
        raise MissingPartError("the documentation", "run `make docs` in the repository, or read its docs/ folder")
    name, mark, section = args.page.removesuffix(".md").partition("#")
    files = [file for file in site.rglob("*.html") if file.name != "404.html"]
    pages = {file.relative_to(site).with_suffix("").as_posix(): file for file in files}
    found = pages.get(name) or pages.get(f"tutorials/{name}")
    if found is None:
        raise UnknownNameError("page", name, sorted(pages))
    address = f"{found.resolve().as_uri()}{mark}{section}"
    print(address)
    if not args.no_browser:
        webbrowser.open(address)
