"""What wasn't imported exactly says what to do, and doing that works."""

from pathlib import Path

import pytest

from grip_bt.cli.__main__ import main
from grip_bt.formats.smach import advice, import_file, import_with_execution

DATA = Path(__file__).parent / "data"
ROOMS = {"CleanAll": {"rooms": ["bath", "attic"]}}
STATIC_FAILURES = ("dynamic_goals", "executed/given_rooms")


def test_what_fails_when_it_is_read_says_how_a_run_helps():
    for name in STATIC_FAILURES:
        said = advice(import_file(DATA / f"{name}.py"), executed=False)
        assert said[0].startswith("some values are known only at run time; if you trust the file, import it again with")
    assert "with `CleanAll: {rooms: ...}`" in advice(import_file(DATA / "executed/given_rooms.py"), False)[1]
    assert advice(import_file(DATA / "nested_with.py"), False) == []


def test_labels_from_functions_that_always_give_the_same_are_read():
    (container,) = import_file(DATA / "executed/computed_steps.py").containers
    assert (container.verdict, list(container.added)[0::3]) == ("exact", ["RED_SMALL", "BLUE_LARGE"])


def test_without_a_run_all_but_two_of_56_containers_are_imported():
    files = [*DATA.glob("*.py"), *DATA.glob("executed/*.py")]
    failed = [(file.stem, c) for file in files for c in import_file(file).containers if c.verdict == "failed"]
    assert sorted(stem for stem, _ in failed) == ["dynamic_goals", "given_rooms"]
    assert all("is known only at run time" in str(c.issues[0]) for _, c in failed)


def test_98_percent_of_the_containers_are_imported_when_files_that_need_it_are_run():
    files = [*DATA.glob("*.py"), *DATA.glob("executed/*.py")]
    read = {file: import_file(file) for file in files}
    total = sum(len(imported.containers) for imported in read.values())
    failed = []
    for file, imported in read.items():
        if imported.verdicts()["failed"]:
            imported = import_with_execution(file, given=ROOMS)
            failed += [file.stem] * imported.verdicts()["failed"]
            if imported.verdicts()["failed"]:
                assert "write a function without arguments" in advice(imported, True, ROOMS)[0]
    assert (total, failed) == (56, ["dynamic_goals"])


@pytest.mark.parametrize("text", ["CleanAll:\n  rooms: [bath, attic]\n", '{"CleanAll": {"rooms": ["bath", "attic"]}}'])
def test_arguments_are_given_in_yaml_or_json(text, tmp_path, capsys):
    (tmp_path / "args.yaml").write_text(text)
    command = ["import", str(DATA / "executed" / "given_rooms.py"), "--from", "smach", "--execute"]
    assert main(command) == 1
    assert (
        "to do: what CleanAll is given: --arguments FILE.yaml with `CleanAll: {rooms: ...}`" in capsys.readouterr().out
    )
    assert main([*command, "--arguments", str(tmp_path / "args.yaml")]) == 0
    assert "given_rooms.py: 1 exact" in capsys.readouterr().out


def test_a_store_of_userdata_that_is_made_for_a_machine_is_its_own_and_one_for_two_is_told(tmp_path):
    text = (DATA / "own_userdata.py").read_text()
    (container,) = import_file(DATA / "own_userdata.py").containers
    assert (container.verdict, container.userdata) == ("exact", {"boxes": 4, "limits": {"step": 2, "most": 9}})
    both = text.replace(
        "    return sm\n", "    other = smach.StateMachine(outcomes=['x'])\n    other.userdata = data\n    return sm\n"
    )
    (tmp_path / "both.py").write_text(both)
    told = [str(issue) for c in import_file(tmp_path / "both.py").containers for issue in c.issues]
    assert any("its userdata becomes `data`: SMACH shares that store" in each for each in told)
