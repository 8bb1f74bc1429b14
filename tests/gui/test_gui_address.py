"""A server that is started again is found by the pages that are open; nobody else learns its token."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from grip_bt.base.errors import GripError
from grip_gui.security import listen


def test_a_server_that_is_started_again_has_its_port_and_token(tmp_path: Path) -> None:
    file = tmp_path / ".grip" / "editor.json"
    first, token = listen(file, 0)
    address = first.getsockname()
    assert file.stat().st_mode & 0o777 == 0o600
    with first:
        second, same = listen(file, 0)
        with second:
            assert same == token
            assert second.getsockname() != address
    # The last one counts, and a port that is asked for comes before it.
    third, same = listen(file, address[1])
    with third:
        assert (third.getsockname(), same) == (address, token)
        with pytest.raises(GripError, match="isn't free"):
            listen(file, address[1])
    fourth, same = listen(file, 0)
    with fourth:
        assert (fourth.getsockname(), same) == (address, token)


@pytest.mark.parametrize(
    "text", ["", "[]", '{"port": 1}', '{"port": "x", "token": 1}', '{"port": 1, "token": "short"}', None]
)
def test_what_others_can_read_or_isnt_an_address_counts_for_nothing(tmp_path: Path, text: str | None) -> None:
    file = tmp_path / "editor.json"
    listen(file, 0)[0].close()
    known = file.read_text(encoding="utf-8")
    if text is None:
        file.chmod(0o644)
    else:
        file.write_text(text, encoding="utf-8")
    listener, token = listen(file, 0)
    listener.close()
    assert token not in known
    assert len(token) >= 32
    assert file.stat().st_mode & 0o777 == 0o600


def test_that_it_cant_be_kept_keeps_nobody_from_editing(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    os.close(os.open(tmp_path / "in_the_way", os.O_CREAT))
    listener, token = listen(tmp_path / "in_the_way" / "editor.json", 0)
    listener.close()
    assert len(token) >= 32
    assert "isn't kept" in caplog.text
