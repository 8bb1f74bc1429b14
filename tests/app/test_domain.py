"""Runs beside each other get different DDS domains; the user's choice wins."""

from contextlib import ExitStack

import pytest

from grip_bt.app.domain import DOMAINS, own_domain
from grip_bt.errors import GripError


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
