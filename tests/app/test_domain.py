"""Runs beside each other get different DDS domains; the user's choice wins."""

import os
import subprocess
import sys
import tempfile
from contextlib import ExitStack

import pytest

from grip_bt.base.errors import GripError
from grip_bt.ros.environment import DOMAINS, free_domain, own_domain


@pytest.fixture(autouse=True)
def _own_folder(monkeypatch, tmp_path):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))


def test_every_run_has_a_domain_of_its_own_until_none_is_left():
    with ExitStack() as stack:
        taken = {stack.enter_context(own_domain()) for _ in DOMAINS}
        assert taken == set(DOMAINS)
        with pytest.raises(GripError, match="set ROS_DOMAIN_ID"):
            stack.enter_context(own_domain())


def test_a_domain_is_free_again_after_its_run():
    with own_domain() as first:
        pass
    with own_domain() as again:
        assert again == first


def test_the_domain_of_the_user_wins(monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "42")
    with own_domain() as one, own_domain() as other:
        assert one == other == 42


def test_a_free_domain_is_nobodys_also_where_the_user_chose_one(monkeypatch):
    with own_domain() as run:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(run))
        script = "from grip_bt.ros.environment import free_domain\nwith free_domain() as d: print(d)"
        env = dict(os.environ, TMPDIR=tempfile.gettempdir())
        with free_domain() as first, free_domain(1) as second:
            done = subprocess.run([sys.executable, "-c", script], env=env, capture_output=True, text=True, check=True)
            assert len({run, first, second, int(done.stdout)}) == 4
