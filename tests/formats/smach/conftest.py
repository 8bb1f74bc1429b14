"""Imports of legacy code leave the process as it was: other tests look at what `install` does."""

import sys

import pytest

from grip_bt import smach_compat


@pytest.fixture(autouse=True)
def own_smach():
    before, path = set(sys.modules), list(sys.path)
    yield
    for name in set(sys.modules) - before:
        if name.startswith(("grip_legacy_", "grip_node_")) or name == "states_lib":
            del sys.modules[name]
    sys.path[:] = path
    smach_compat.uninstall()
