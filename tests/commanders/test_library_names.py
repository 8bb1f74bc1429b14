"""Names that are written down, so that no library has to be loaded for them, are those of the libraries."""

from __future__ import annotations

import ompl.base as ob
import ompl.geometric as og

from grip_bt.commanders.kinematics.ik import SOLVERS
from grip_bt.commanders.planning.search import BITRRT
from grip_bt.commanders.settings import PLANNERS
from grip_bt.commanders.settings import SOLVERS as WRITTEN


def test_planners_are_those_that_are_bound_and_ours():
    classes = ((name, getattr(og, name)) for name in dir(og))
    bound = [name for name, kind in classes if isinstance(kind, type) and issubclass(kind, ob.Planner)]
    assert tuple(sorted([*bound, BITRRT])) == PLANNERS


def test_solvers_are_those_that_there_are():
    assert tuple(SOLVERS) == WRITTEN
