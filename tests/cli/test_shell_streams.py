"""The command's streams: pipes whose reader has gone, full disks, closed numbers, other character sets, Ctrl-C."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
GRIP = [sys.executable, "-m", "grip_bt.cli"]
EXAMPLE = str(ROOT / "examples" / "tasks" / "reactive_pick.yaml")
TASK = "grip: 1\nname: first\noutcomes: {success: success}\nroot: {node: flow/log, with: {message: ü → ñ}}\n"


def grip(*words, shell=None, cwd=None, **settings):
    """Return what became of `grip WORDS`, with its output buffered as a pipe's or a file's is."""
    environment = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHONUNB", "PYTHONIO"))}
    command = [*GRIP, *words] if shell is None else ["bash", "-c", f'"$@" {shell}', "bash", *GRIP, *words]
    given = {**environment, "PYTHONPATH": f"{ROOT}:{ROOT / 'gui'}:{ROOT / 'sim'}", **settings}
    return subprocess.run(command, capture_output=True, cwd=cwd, env=given, check=False)


@pytest.mark.parametrize("words", [["check", EXAMPLE], ["--help"], ["convert", EXAMPLE, "--to", "svg"]])
def test_a_reader_that_goes_away_is_nothing_to_speak_of(words):
    done = grip(*words, shell='| true; exit "${PIPESTATUS[0]}"')
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.parametrize("words", [["check", EXAMPLE], ["--help"], ["convert", EXAMPLE, "--to", "svg"]])
def test_a_full_disk_below_stdout_is_said(words):
    done = grip(*words, shell="> /dev/full")
    assert done.returncode == 1
    assert done.stderr.decode().splitlines() == [
        "grip: stdout: No space left on device; the output is incomplete: redirect it elsewhere, or free some space"
    ]


@pytest.mark.parametrize("words", [["check", EXAMPLE], ["convert", EXAMPLE, "--to", "svg"]])
def test_a_closed_stdout_is_no_error(words):
    done = grip(*words, shell=">&- <&-")
    assert (done.returncode, done.stderr) == (0, b"")


def test_a_terminal_without_our_characters_gets_others_in_their_place(tmp_path):
    (tmp_path / "ü.yaml").write_text(TASK, encoding="utf-8")
    done = grip("check", "ü.yaml", cwd=tmp_path, PYTHONIOENCODING="ascii")
    assert (done.returncode, done.stdout) == (0, b"\\xfc.yaml: ok\n")


def test_a_document_on_stdout_is_in_utf_8_whatever_the_terminal_has(tmp_path):
    (tmp_path / "t.yaml").write_text(TASK, encoding="utf-8")
    for words in (["convert", "t.yaml", "--to", "yaml"], ["apply", "t.yaml", "[]", "--dry-run"]):
        done = grip(*words, cwd=tmp_path, PYTHONIOENCODING="latin-1")
        assert done.stdout.decode("utf-8") == TASK


def test_a_file_name_that_is_no_text_can_be_spoken_of(tmp_path):
    name = os.fsdecode(b"\xff.yaml")
    (tmp_path / name).write_text(TASK, encoding="utf-8")
    done = grip("check", name, cwd=tmp_path, PYTHONIOENCODING="utf-8")
    assert (done.returncode, done.stdout) == (0, b"\\udcff.yaml: ok\n")


def test_ctrl_c_while_grip_is_being_loaded_is_one_sentence(tmp_path):
    # The signal comes with the first module of ours that is imported, deep inside of the loading.
    (tmp_path / "sitecustomize.py").write_text(
        "import os, signal, sys\n"
        "class Stop:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name == 'grip_bt.cli.task':\n"
        f"            os.kill(os.getpid(), {int(signal.SIGINT)})\n"
        "sys.meta_path.insert(0, Stop())\n"
    )
    paths = ":".join(str(path) for path in (tmp_path, ROOT, ROOT / "gui", ROOT / "sim"))
    done = grip("check", EXAMPLE, PYTHONPATH=paths)
    assert (done.returncode, done.stderr) == (130, b"grip: stopped\n")
