"""`grip docs`: the documentation, which comes built with an installed GRIP, in the browser; no network is needed."""

from __future__ import annotations

import argparse
import webbrowser
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import grip_bt
from grip_bt.base.errors import MissingPartError, UnknownNameError

_HOME = Path(grip_bt.__file__).parent
_SITES = (_HOME / "_docs", _HOME.parent / "build" / "site")
"""Where an installation has it, and where `make docs` builds it."""


class _Pages(SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: object) -> None:
        """Say nothing of requests."""


def add_docs(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("page", nargs="?", default="index", metavar="PAGE", help="such as running, or nodes#arm")
    parser.add_argument("--port", type=int, default=0, help="port on this machine (default: a free one)")
    parser.add_argument("--no-browser", action="store_true", help="only print the address")


def run_docs(args: argparse.Namespace) -> None:
    """Serve the site on this machine until Ctrl-C: browsers don't let the page of a file search."""
    site = next((folder for folder in _SITES if (folder / "index.html").is_file()), None)
    if site is None:
        raise MissingPartError("the documentation", "run `make docs` in the repository, or read its docs/ folder")
    name, mark, section = args.page.removesuffix(".md").partition("#")
    pages = [file.relative_to(site).with_suffix("").as_posix() for file in site.rglob("*.html")]
    found = next((page for page in (name, f"tutorials/{name}") if page in pages), None)
    if found is None:
        raise UnknownNameError("page", name, sorted(pages))
    with ThreadingHTTPServer(("127.0.0.1", args.port), partial(_Pages, directory=str(site))) as server:
        address = f"http://127.0.0.1:{server.server_port}/{found}.html{mark}{section}"
        print(f"{address}\nCtrl-C ends it", flush=True)
        if not args.no_browser:
            webbrowser.open(address)
        server.serve_forever()
