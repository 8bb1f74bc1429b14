"""The processes that construction runs in: each file sees what it would see alone, and what waits ends."""

import marshal
import os
import signal
import threading
from functools import partial
from pathlib import Path
from types import SimpleNamespace

from smach_runs import record

from grip_bt.formats.smach import Recorder, import_file, import_files, sandbox
from grip_bt.formats.smach.found import Run
from grip_bt.formats.smach.recorder import _TrackedFinder
from grip_bt.nodes import smach_source
from grip_bt.nodes.smach_source import workspace_of
from grip_bt.nodes.stand_ins import StandInFinder

LIBRARY = """
import smach
import names

NAMES = ["A"] + names.MORE


class Step(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=["done"])

"""
MISSION = """{first}


def mission():
    sm = smach.StateMachine(outcomes=["done"])
    with sm:
        for label in NAMES + [{more!r}]:
            smach.StateMachine.add(label, Step(), {{"done": "done"}})
    return sm
"""
FIRST = [
    "from library import NAMES, Step, smach",
    "import os\nfrom library import NAMES, Step, smach",
    '"""It says what it is."""\nfrom __future__ import annotations\nfrom library import NAMES, Step, smach',
    "from library import NAMES, Step, smach",
    "from library import NAMES, Step, smach\nNAMES.append('CHANGED')",
    "import names\nnames.MORE.append('BEFORE')\nfrom library import NAMES, Step, smach",
]
WANTED = [["A", "N"]] * 4 + [["A", "N", "CHANGED"], ["A", "N", "BEFORE"]]


def test_files_of_one_workspace_see_what_each_would_see_alone(tmp_path):
    for package in ("app", "library"):
        (tmp_path / package / "src" / "library").mkdir(parents=True)
        (tmp_path / package / "package.xml").write_text(f"<package><name>{package}</name></package>")
    (tmp_path / "library/src/library/__init__.py").write_text(LIBRARY)
    (tmp_path / "library/src/names.py").write_text("MORE = ['N']\n")
    (tmp_path / "app/src/library").rmdir()
    files = [tmp_path / "app" / f"mission_{number}.py" for number in range(len(FIRST))]
    for number, file in enumerate(files):
        file.write_text(MISSION.format(first=FIRST[number], more=str(number)))
    own = tmp_path / "app" / "alone" / "mission.py"
    own.parent.mkdir()
    own.write_text(files[0].read_text())
    (own.parent / "names.py").write_text("MORE = ['OF_ITS_OWN']\n")
    for file, labels, more in [*zip(files, WANTED, "012345", strict=True), (own, ["A", "OF_ITS_OWN"], "0")]:
        (found,) = record(file, tmp_path).containers
        assert (list(found.added), found.verdict) == ([*labels, more], "exact")


def test_what_only_waits_is_ended_long_before_its_time_is_over(monkeypatch):
    monkeypatch.setattr(sandbox, "_LOOK", 0.02)
    told = sandbox.in_child(threading.Event().wait, lambda error: Run(builder="b", error=error), 1000)
    assert Run.model_validate_json(told).error == "it waits for something"


def test_what_names_no_smach_is_not_converted_from_python_2(tmp_path, monkeypatch):
    def converter():
        raise AssertionError("it was converted")

    monkeypatch.setattr(smach_source, "_converter", converter)
    (tmp_path / "driver.py").write_text("print 'moved'\n")
    (driven,) = import_files([tmp_path / "driver.py"], tmp_path)
    assert (driven.containers, driven.error) == ([], "")


def test_a_file_is_recorded_while_what_others_run_waits(tmp_path):
    """Of either kind there is a process that is free while another one is kept busy."""
    (tmp_path / "mission.py").write_text("import smach\n\nsm = smach.StateMachine(outcomes=['done'])\n")
    with Recorder() as recorder:
        busy = [kind.get() for kind in recorder._free]
        assert len(recorder.record(tmp_path / "mission.py", tmp_path)[0].runs) >= 1
        for kind, process in zip(recorder._free, busy, strict=True):
            kind.put(process)


def test_of_packages_of_one_name_a_files_own_counts(tmp_path):
    for copy in ("new", "old"):
        (tmp_path / copy).mkdir()
        (tmp_path / copy / "package.xml").write_text("<package><name>walks</name></package>")
        (tmp_path / copy / "node.py").touch()
    for copy in ("new", "old"):
        assert workspace_of(tmp_path / copy / "node.py", tmp_path).packages == {"walks": tmp_path / copy}


def test_a_part_of_an_installed_library_is_no_legacy_code_wherever_it_is_installed(tmp_path):
    folders = {name: tmp_path / name / "shelf" for name in ("own", "venv/site-packages")}
    for folder in folders.values():
        folder.mkdir(parents=True)
        (folder / "books.py").write_text("")
    finder = _TrackedFinder(workspace_of(tmp_path / "legacy.py", tmp_path), StandInFinder())
    found = [finder.find_spec("shelf.books", [str(folder)]) is not None for folder in folders.values()]
    assert found == [True, False]


KILLED = """import smach


class Go(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=["there"])


def build():
    sm = smach.StateMachine(["there"])
    with sm:
        smach.StateMachine.add("A", Go())
    return sm
"""


def test_a_recording_process_that_is_killed_is_begun_again_and_one_that_is_killed_each_time_is_told(
    tmp_path, monkeypatch
):
    """As by the system when memory is short."""
    file = tmp_path / "legacy.py"
    file.write_text(KILLED)
    start, survivors = Recorder._start, []

    def started(recorder, number):
        process = start(recorder, number)
        if survivors:
            return process
        answers = process.stdout
        process.stdout = SimpleNamespace(close=answers.close, readline=partial(killed_before, process, answers))
        return process

    monkeypatch.setattr(Recorder, "_start", started)
    with Recorder() as recorder:
        (failed,) = import_file(file, recorder=recorder).containers
        (reason,) = [issue.message for issue in failed.issues if "wasn't built" in issue.message]
        assert "the process that runs its construction was killed by SIGKILL, perhaps for want of memory" in reason
        assert "without --execute, which only reads it" in reason
        survivors.append(True)
        assert [each.verdict for each in import_file(file, recorder=recorder).containers] == ["exact"]


def killed_before(process, answers):
    os.kill(process.pid, signal.SIGKILL)
    return answers.readline()


def test_a_library_that_one_file_has_loaded_is_another_module_where_a_workspace_has_its_own(tmp_path):
    named = "import smach\nfrom {module} import {name}\nNAMES = [str({name})]\n"
    step = LIBRARY.partition("NAMES")[2].partition("\n")[2]
    texts = {
        "one": named.format(module="networkx", name="__name__"),
        "two": named.format(module="networkx.algorithms", name="__name__"),
        "own": named.format(module="networkx", name="OWN"),
        "last": named.format(module="networkx.utils", name="__name__"),
    }
    labels = {}
    with Recorder() as recorder:
        for folder, text in texts.items():
            (tmp_path / folder).mkdir()
            file = tmp_path / folder / "mission.py"
            file.write_text(text + step + MISSION.format(first="", more="M"))
            if folder == "own":
                (tmp_path / "own" / "networkx.py").write_text("OWN = 'OWN'\n")
            (found,) = import_file(file, None, recorder).containers
            labels[folder] = (found.verdict, next(iter(found.added)))
    assert labels == {
        "one": ("exact", "networkx"),
        "two": ("exact", "networkx.algorithms"),
        "own": ("exact", "OWN"),
        "last": ("exact", "networkx.utils"),
    }


SHARED = """import smach
from library import NAMES

sm = smach.StateMachine(["done"])
with sm:
    for name in NAMES:
        smach.StateMachine.add(name, smach.State(["done"]), {"done": "done"})
"""


def test_what_a_process_has_compiled_is_taken_by_the_others_until_the_file_changes(tmp_path):
    library, missions = tmp_path / "library.py", [tmp_path / f"mission_{number}.py" for number in range(3)]
    library.write_text("NAMES = ['A']\n")
    for mission in missions:
        mission.write_text(SHARED)
    with Recorder() as recorder:
        labels(recorder, missions[0])
        shelf = Path(recorder._shelf.name)
        kept = {marshal.loads(file.read_bytes())[0][0]: file for file in shelf.iterdir()}
        assert sorted(kept) == [str(library), str(missions[0])]
        key, _ = marshal.loads(kept[str(library)].read_bytes())
        other = compile("NAMES = ['B']\n", str(library), "exec")
        for process in (free.get() for free in recorder._free * 2):  # the next ones have nothing of their own
            if process is not None:
                process.communicate()
        for free in recorder._free * 2:
            free.put(None)
        kept[str(library)].write_bytes(marshal.dumps((key, (other, []))))
        assert labels(recorder, missions[1]) == ["B"]
        library.write_text("NAMES = ['C', 'D']\n")
        assert labels(recorder, missions[2]) == ["C", "D"]
    assert not shelf.exists()


def labels(recorder, mission):
    (found,) = import_file(mission, recorder=recorder).containers
    assert found.verdict == "exact"
    return list(found.added)
