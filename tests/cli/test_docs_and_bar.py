"""`grip docs`, the line that says how far something is, and `grip doctor --fix`."""

import io
import subprocess
import threading
from urllib.request import urlopen

import pytest

from grip_bt.cli import docs, doctor, terminal
from grip_bt.cli.__main__ import main


@pytest.fixture
def site(tmp_path, monkeypatch):
    (tmp_path / "tutorials").mkdir()
    for name in ("index", "running", "tutorials/first_grasp"):
        (tmp_path / f"{name}.html").write_text(f"<html>{name}")
    monkeypatch.setattr(docs, "_SITES", (tmp_path / "not_there", tmp_path))
    return tmp_path


@pytest.mark.parametrize(
    ("word", "page"),
    [
        ([], "index.html"),
        (["running#stop"], "running.html#stop"),
        (["running.md"], "running.html"),
        (["first_grasp"], "tutorials/first_grasp.html"),
    ],
)
def test_a_page_is_served_and_opened_by_its_name(site, capsys, monkeypatch, word, page):
    opened, read = [], []

    def answer_once(server):
        address = f"http://127.0.0.1:{server.server_port}/{page}"
        reader = threading.Thread(target=lambda: read.append(urlopen(address).read().decode()))
        reader.start()
        server.handle_request()
        reader.join()

    monkeypatch.setattr(docs.webbrowser, "open", opened.append)
    monkeypatch.setattr(docs.ThreadingHTTPServer, "serve_forever", answer_once)
    assert main(["docs", *word]) == 0
    assert opened == [capsys.readouterr().out.splitlines()[0]]
    assert opened[0].endswith(f"/{page}")
    assert read == [f"<html>{page.partition('.')[0]}"]
    assert main(["docs", *word, "--no-browser"]) == 0
    assert len(opened) == 1


def test_an_unknown_page_is_answered_with_the_nearest_and_no_site_with_what_builds_it(site, capsys, monkeypatch):
    assert main(["docs", "runing"]) == 1
    assert "did you mean 'running'?" in capsys.readouterr().err
    monkeypatch.setattr(docs, "_SITES", ())
    assert main(["docs"]) == 1
    assert "make docs" in capsys.readouterr().err


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.mark.parametrize(
    ("stream", "quiet", "shown"), [(Terminal, False, True), (Terminal, True, False), (io.StringIO, False, False)]
)
def test_a_bar_is_for_terminals_that_want_it_and_leaves_nothing_behind(monkeypatch, stream, quiet, shown):
    stderr = stream()
    monkeypatch.setattr(terminal.sys, "stderr", stderr)
    monkeypatch.setattr(terminal, "quiet", quiet)
    monkeypatch.setattr(terminal, "SOON", 0.0)
    with terminal.Bar("files") as bar:
        bar(2, 8, "a.py")
        while shown and "2/8" not in stderr.getvalue():
            pass
    said = stderr.getvalue()
    assert ("files" in said and "a.py" in said) == shown
    assert not said or said.endswith("\x1b[2K"), "nothing is left behind"


def test_doctor_runs_pip_and_as_root_apt(monkeypatch, capsys):
    ran = []
    monkeypatch.setattr(
        doctor,
        "_CHECKS",
        (
            lambda: doctor.Finding("motion", "missing", "no pin", doctor._INSTALL.format(extra="motion")),
            lambda: doctor.Finding("compiler", "missing", "no g++", "sudo apt-get install g++ python3-dev"),
        ),
    )
    monkeypatch.setattr(subprocess, "run", lambda command, **_: ran.append(command[1:]))
    monkeypatch.setattr(doctor.os, "geteuid", lambda: 0)
    assert main(["doctor", "--fix"]) == 1
    assert ran == [["-m", "pip", "install", "grip-bt[motion]"], ["install", "-y", "g++", "python3-dev"]]
    ran.clear()
    monkeypatch.setattr(doctor.os, "geteuid", lambda: 1000)
    assert main(["doctor", "--fix"]) == 1
    assert len(ran) == 1
    assert "fix: sudo apt-get install g++ python3-dev" in capsys.readouterr().out
