"""The committed page is the one that its sources give; the types are those of the models."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from grip_gui.typescript import TARGET, typescript

GUI = Path(__file__).parents[2] / "gui"
FRONTEND, STATIC = GUI / "frontend", GUI / "grip_gui" / "static"
FILES = ["index.html", "package-lock.json", "package.json", "tsconfig.json", "vite.config.ts"]


def test_types_of_the_page_are_fresh() -> None:
    assert TARGET.read_text(encoding="utf-8") == typescript(), (
        "run `python -m grip_gui.typescript`, then build the page"
    )


def test_the_committed_page_was_built_from_these_sources() -> None:
    sources = [path.relative_to(FRONTEND).as_posix() for path in (FRONTEND / "src").rglob("*") if path.is_file()]
    digest = hashlib.sha256()
    for name in sorted([*FILES, *sources]):
        digest.update(name.encode() + b"\0" + (FRONTEND / name).read_bytes() + b"\0")
    built = json.loads((STATIC / "build-info.json").read_text(encoding="utf-8"))
    assert built == {"source": digest.hexdigest()}, "the page is stale: `npm ci && npm run build` in gui/frontend"


def test_the_page_needs_nothing_from_elsewhere() -> None:
    page = (STATIC / "index.html").read_text(encoding="utf-8")
    assert not re.findall(r"(?:src|href)=\"(?:https?:)?//", page)
    for sheet in STATIC.rglob("*.css"):
        assert "url(http" not in sheet.read_text(encoding="utf-8")


@pytest.mark.parametrize("folder", ["frontend", "e2e"])
def test_lock_files_name_no_download_hosts(folder: str) -> None:
    lock = json.loads((GUI / folder / "package-lock.json").read_text(encoding="utf-8"))
    assert lock["packages"]
    assert not [name for name, entry in lock["packages"].items() if "resolved" in entry]


def test_notices_name_all_that_is_shipped() -> None:
    notices = (STATIC / "THIRD_PARTY_NOTICES.txt").read_text(encoding="utf-8")
    assert "Eclipse Public License" in notices  # of ELK's worker, which is shipped as it is
    for package in json.loads((FRONTEND / "package.json").read_text(encoding="utf-8"))["dependencies"]:
        assert f"\n{package} " in notices


def first_load() -> list[Path]:
    """Return the scripts that the page loads before anybody asks for a view: those that import each other at once."""
    page = (STATIC / "index.html").read_text(encoding="utf-8")
    found = {STATIC / name for name in re.findall(r'(?:src|href)="\./(assets/[\w-]+\.js)"', page)}
    waiting = list(found)
    while waiting:
        text = waiting.pop().read_text(encoding="utf-8")
        for name in re.findall(r'(?:from|import)\s*"\./([\w-]+\.js)"', text):
            script = STATIC / "assets" / name
            if script not in found:
                found.add(script)
                waiting.append(script)
    return sorted(found)


def test_the_first_load_stays_small() -> None:
    import gzip

    scripts = first_load()
    assert {script.name for script in scripts} >= {"index.js", "vendor.js"}
    assert "text-vendor.js" not in {script.name for script in scripts}
    total = sum(len(gzip.compress(script.read_bytes())) for script in scripts)
    assert total < 250_000, f"{total} bytes of compressed script"


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("npm") is None, reason="npm isn't installed")
def test_a_fresh_build_gives_the_same_bytes(tmp_path: Path) -> None:
    frontend = tmp_path / "frontend"
    shutil.copytree(FRONTEND, frontend, ignore=shutil.ignore_patterns("node_modules"))
    install = subprocess.run(
        ["npm", "ci", "--prefer-offline", "--no-audit", "--no-fund"], cwd=frontend, capture_output=True, text=True
    )
    if install.returncode:
        pytest.skip(f"npm ci can't fetch the packages here: {install.stderr.strip().splitlines()[-1:]}")
    build = subprocess.run(["npm", "run", "build"], cwd=frontend, capture_output=True, text=True)
    assert build.returncode == 0, build.stdout + build.stderr
    made = tmp_path / "grip_gui" / "static"
    files = {path.relative_to(STATIC) for path in STATIC.rglob("*") if path.is_file()}
    assert {path.relative_to(made) for path in made.rglob("*") if path.is_file()} == files
    changed = [str(name) for name in sorted(files) if (made / name).read_bytes() != (STATIC / name).read_bytes()]
    assert not changed


@pytest.mark.skipif(shutil.which("node") is None, reason="NOT RUN: Node isn't installed")
def test_a_page_that_is_built_again_stays_served(tmp_path: Path) -> None:
    """Builds of two sizes are put in place in turn, while somebody reads: every file is there, and whole."""
    served, sizes = tmp_path / "static", {"one": 300_000, "two": 500_000}
    for build, size in sizes.items():
        (tmp_path / build / "assets").mkdir(parents=True)
        for name in ("index.html", "build-info.json", "assets/index.js", f"assets/{build}.js"):
            (tmp_path / build / name).write_text(build[0] * size)
    script = (
        f"import {{ putInPlace }} from {json.dumps((FRONTEND / 'scripts' / 'put_in_place.mjs').as_uri())};"
        "const [one, two, served] = process.argv.slice(1);"
        "putInPlace(one, served); console.log('there');"
        "for (let i = 0; i < 60; i++) putInPlace(i % 2 ? one : two, served);"
    )
    command = ["node", "--input-type=module", "-e", script, str(tmp_path / "one"), str(tmp_path / "two"), str(served)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "there\n"
        whole = {build[0] * size for build, size in sizes.items()}
        reads = 0
        while process.poll() is None:
            for name in ("index.html", "build-info.json", "assets/index.js"):
                assert (served / name).read_text() in whole
                reads += 1
    assert process.returncode == 0
    assert reads > 0
    # what the last build hasn't is gone, and nothing is left of how the files came
    assert {path.name for path in served.rglob("*") if path.is_file()} == {
        "index.html",
        "build-info.json",
        "index.js",
        "one.js",
    }
