"""A capsule is one file that has all of a run in it, and asks nothing of anybody."""

import base64
import json
import os
import re
import shutil
import subprocess
import zlib
from html.parser import HTMLParser
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grip_bt.app.runs.capsule import MOST_TEXT, columns_of, write_capsule
from grip_bt.cli.__main__ import main
from grip_bt.runtime import Event, Journal, JournalReader

E2E = Path(__file__).parents[2] / "gui" / "e2e"
CHROMIUM = os.environ.get("CHROMIUM", "/usr/bin/chromium")
TASK = """\
grip: 1
name: short
doc: Waits, a failure that is mended, and a machine </script><b>.
data: {reached: {type: int, value: 0}}
root:
  kind: sequence
  children:
    first: {node: flow/wait, with: {seconds: 0.3}}
    attempts:
      kind: fallback
      children:
        broken: {node: flow/fail, with: {code: no_plan, message: the way is blocked}}
        second: {node: flow/set, with: {value: 1}, out: {value: reached}}
    machine:
      kind: state_machine
      initial: a
      outcomes: {done: success}
      children:
        a: {node: flow/wait, with: {seconds: 0.2}, on: {success: b}}
        b: {node: flow/set, with: {value: 2}, out: {value: reached}, on: {success: done}}
"""


class Page(HTMLParser):
    """The tags of a page, their attributes, and the text of its data."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.facts, self._in = [], "", None
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self._in = dict(attrs).get("id") if tag == "script" else None

    def handle_data(self, data):
        if self._in == "facts":
            self.facts += data

    def handle_endtag(self, tag):
        self._in = None


@pytest.fixture(scope="module")
def capsule(tmp_path_factory):
    """A capsule of a run, and the events that the journal has of it."""
    folder = tmp_path_factory.mktemp("capsule")
    (folder / "short.yaml").write_text(TASK)
    assert main(["run", str(folder / "short.yaml"), "--in-process"]) == 0
    journal = folder / ".grip" / "runs.sqlite"
    file = folder / "run.html"
    assert main(["capsule", "last", "--journal", str(journal), "-o", str(file)]) == 0
    with JournalReader(journal) as reader:
        return file, reader.events(reader.runs()[0].id)


def inflated(text):
    return json.loads(zlib.decompress(base64.b64decode(text), -zlib.MAX_WBITS))


def events_in(columns):
    """Read events back as the page does."""
    numbers, steps = inflated(columns["columns"])
    said, t, found = inflated(columns["texts"]), 0, []
    for i, (number, step) in enumerate(zip(numbers, steps, strict=True)):
        t += step
        found.append((round(t / 1e6, 6), *columns["kinds"][number], said.get(str(i), {})))
    return found


def test_the_capsule_has_every_event_of_the_run(capsule):
    file, events = capsule
    columns = json.loads(Page(file.read_text()).facts)["events"]
    found = events_in(columns)
    assert [event[1:6] for event in found] == [(e.path, e.event, e.outcome, e.code, e.meaning) for e in events]
    assert [event[0] for event in found] == pytest.approx([e.t for e in events], abs=1e-6)
    failure = next(e for e in found if e[1] == "attempts/broken" and e[2] == "exit")
    assert failure[6] == {"message": "the way is blocked"}
    assert [e[6]["preview"] for e in found if e[2] == "write"] == ["1", "2"]


def test_both_drawings_name_every_node_and_share_no_identifiers(capsule):
    tags = Page(capsule[0].read_text()).tags
    paths = [attributes["data-path"] for tag, attributes in tags if tag == "g" and "data-path" in attributes]
    nodes = ["/", "first", "attempts", "attempts/broken", "attempts/second", "machine", "machine/a", "machine/b"]
    assert sorted(paths) == sorted(2 * nodes)
    ids = [attributes["id"] for _, attributes in tags if "id" in attributes]
    assert len(ids) == len(set(ids))


def test_the_capsule_loads_nothing_from_elsewhere_and_forbids_it(capsule):
    text = capsule[0].read_text()
    tags = Page(text).tags
    assert not [t for t, a in tags if t in ("link", "img", "iframe", "base", "object") or a.get("src") or a.get("href")]
    assert "url(http" not in text
    policies = [a["content"] for _, a in tags if a.get("http-equiv") == "Content-Security-Policy"]
    assert policies
    assert policies[0].startswith("default-src 'none'")


def test_texts_of_a_task_cant_end_the_script_that_holds_them(capsule):
    page = Page(capsule[0].read_text())
    assert json.loads(page.facts)["doc"].endswith("</script><b>.")
    assert not [tag for tag, _ in page.tags if tag == "b"]


def test_a_hundred_thousand_events_fit_into_two_megabytes(tmp_path):
    with Journal(tmp_path / "runs.sqlite") as journal:
        log = journal.begin("short", "short.yaml", TASK)
        leaves = ["first", "attempts/broken", "attempts/second", "machine/a", "machine/b"]
        for i in range(25_000):
            path, t = leaves[i * 7 % 5], i * 0.0137 + (i * i % 97) * 1e-5
            log.append(t, path, "enter")
            log.append(t + 1e-4, path, "message", data={"text": f"{i * 31 % 1000} mm left of {i}"})
            written = {"variable": "reached", "type": "Pose", "preview": f"Pose(position=[{i * 0.37:.6f}, 0.1, {i}])"}
            log.append(t + 2e-4, path, "write", data=written)
            log.append(t + 3e-4, path, "exit", "failure", "no_plan", {"message": f"attempt {i} found no way"})
        log.end("success", "success")
    with JournalReader(tmp_path / "runs.sqlite") as reader:
        made = write_capsule(reader, log.id, tmp_path / "run.html")
    assert made.events == 100_000
    assert made.size == (tmp_path / "run.html").stat().st_size
    assert made.size <= 2_000_000


def test_of_too_many_texts_some_are_left_out_and_the_page_says_which(tmp_path):
    noise = os.urandom(60_000).hex()
    events = [
        Event(i + 1, i, i, "a", "message", None, None, {"text": noise[i * 100 % 60_000 :][:199]}) for i in range(12_000)
    ]
    columns, left_out = columns_of(events)
    assert left_out.startswith("messages of running nodes")
    assert len(columns["texts"]) <= MOST_TEXT
    assert len(events_in(columns)) == len(events)


@settings(max_examples=40, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.floats(-1e3, 1e6), st.sampled_from("ab"), st.sampled_from(["enter", "exit"]), st.text(max_size=20)
        ),
        max_size=30,
    )
)
def test_columns_hold_any_events(rows):
    events = [
        Event(i + 1, t, t, path, what, None, None, {"x": text} if text else {})
        for i, (t, path, what, text) in enumerate(rows)
    ]
    found = events_in(columns_of(events)[0])
    assert [e[1:3] for e in found] == [(e.path, e.event) for e in events]
    assert [e[6] for e in found] == [e.data for e in events]
    assert [e[0] for e in found] == pytest.approx([e.t for e in events], abs=1e-6)


def test_a_place_that_cant_be_written_is_told(capsule, capsys):
    journal = capsule[0].parent / ".grip" / "runs.sqlite"
    assert main(["capsule", "last", "--journal", str(journal), "-o", "/nowhere/run.html"]) == 1
    assert re.search(r"/nowhere/run.html: can't be written: No such file", capsys.readouterr().err)


@pytest.mark.e2e
@pytest.mark.slow
def test_a_capsule_lights_its_nodes_in_a_browser_without_a_network(capsule):
    if shutil.which("node") is None:
        pytest.skip("NOT RUN: Node isn't installed")
    if not Path(CHROMIUM).exists():
        pytest.skip(f"NOT RUN: no Chromium at {CHROMIUM}; apt install chromium, or set CHROMIUM")
    if not (E2E / "node_modules" / "playwright-core").is_dir():
        pytest.skip("NOT RUN: the browser driver isn't installed; npm ci in gui/e2e")
    command = ["node", str(E2E / "capsule.mjs"), capsule[0].as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
