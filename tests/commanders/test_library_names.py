"""Names that are written down, so that no library has to be loaded for them, are those of the libraries."""

from __future__ import annotations

from grip_bt.commanders.kinematics.ik import SOLVERS
from grip_bt.commanders.planning.search import planners
from grip_bt.commanders.settings import PLANNERS
from grip_bt.commanders.settings import SOLVERS as WRITTEN


def test_planners_are_those_that_are_bound_and_ours():
    assert planners() == PLANNERS


def test_solvers_are_those_that_there_are():
    assert tuple(SOLVERS) == WRITTEN
