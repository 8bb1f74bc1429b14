"""What an import finds doesn't depend on how its path is written, nor on where the folder lies."""

import re

import pytest

SOURCES = {
    "smach": (
        "machine.py",
        """\
import smach


def build():
    sm = smach.StateMachine(outcomes=["done"])
    with sm:
        smach.StateMachine.add("WAIT", smach.CBState(lambda ud: "done", outcomes=["done"]), {"done": "done"})
    return sm
""",
    ),
    "btcpp": (
        "tree.xml",
        '<root BTCPP_format="4"><BehaviorTree ID="Go"><AlwaysSuccess/></BehaviorTree></root>',
    ),
    "grip": (
        "go.yaml",
        "name: go\noutcomes: [done]\nstates:\n"
        "  - counter: {source: counter, initial_value: 0, end_value: 3, output: n,"
        " transitions: {success: counter, finished: done}}\n",
    ),
    "pytrees": (
        "tree.xml",
        '<root main_tree_to_execute="Go"><BehaviorTree ID="Go"><flow.succeed/></BehaviorTree></root>',
    ),
}
WRITTEN = ["legacy", "./legacy", "../work/legacy", "legacy/../legacy", ".kept/legacy"]


@pytest.mark.parametrize("source", SOURCES)
def test_however_the_path_is_written(source, typed, tmp_path, monkeypatch):
    name, text = SOURCES[source]
    for folder in ("legacy", ".kept/legacy"):
        file = tmp_path / "work" / folder / name
        file.parent.mkdir(parents=True)
        file.write_text(text)
    monkeypatch.chdir(tmp_path / "work")
    single = f"/{name}" if source == "pytrees" else ""
    found = set()
    for path in [*WRITTEN, str(tmp_path / "work/legacy")]:
        done = typed("import", f"{path}{single}", "--from", source, "--report")
        assert done.returncode == 0, (path, done.stderr)
        found.add(re.sub(r"\S*/(?=\w+[.])", "", done.stdout))
    assert len(found) == 1, found
