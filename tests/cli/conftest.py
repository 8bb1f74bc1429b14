"""The command in this process, where all that it loads is loaded already."""

from __future__ import annotations

import os
from collections.abc import Callable
from subprocess import CompletedProcess
from unittest import mock

import pytest

from grip_bt.cli.__main__ import main


@pytest.fixture
def typed(capfd: pytest.CaptureFixture[str]) -> Callable[..., CompletedProcess[str]]:
    """Run `grip` with words; what it and the processes that it starts write is in the result."""

    def run(*words: object) -> CompletedProcess[str]:
        capfd.readouterr()
        with mock.patch.dict(os.environ):  # a command tells the processes that it starts by these
            try:
                status = main([str(word) for word in words])
            except SystemExit as wrong:
                status = int(str(wrong.code))
        said = capfd.readouterr()
        return CompletedProcess(words, status, said.out, said.err)

    return run
