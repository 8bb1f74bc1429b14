"""The documentation as a site: every page is in it, every link and anchor of a page leads somewhere."""

import re
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
LINK = re.compile(r"\]\((?!https?:|mailto:)([^)\s#]*)(?:#([^)\s]+))?\)")
FENCE = re.compile(r"^```.*?^```$", re.DOTALL | re.MULTILINE)


def listed(part):
    """Return the files of a navigation, depth first."""
    if isinstance(part, str):
        return [part]
    return [file for each in (part.values() if isinstance(part, dict) else part) for file in listed(each)]


def anchors(page):
    """Return what the headings of a page are called in addresses."""
    headings = re.findall(r"^#+ (.*)$", FENCE.sub("", page.read_text(encoding="utf-8")), re.MULTILINE)
    plain = (re.sub(r"[`*]|\[([^]]*)\]\([^)]*\)", r"\1", heading).lower() for heading in headings)
    return {re.sub(r"[\s-]+", "-", re.sub(r"[^\w\s-]", "", text).strip()) for text in plain}


def test_every_page_has_its_place_and_every_place_a_page():
    site = yaml.safe_load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"))
    pages = [str(page.relative_to(DOCS)) for page in PAGES]
    assert sorted(listed(site["nav"])) == pages


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_its_links_lead_somewhere(page):
    for file, anchor in LINK.findall(FENCE.sub("", page.read_text(encoding="utf-8"))):
        target = (page.parent / file).resolve() if file else page
        assert target.exists(), f"{page.name}: {file}"
        if anchor:
            assert anchor in anchors(target), f"{page.name}: {file}#{anchor} (there are {sorted(anchors(target))})"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_its_fences_are_rendered(page):
    """What follows the language of a fence is a title, or the site shows it as text."""
    for line in re.findall(r"^```(.*)$", page.read_text(encoding="utf-8"), re.MULTILINE):
        assert re.fullmatch(r'|\w+( title="[^"]+")?', line), f"{page.name}: {line}"
