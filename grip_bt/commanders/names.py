"""Names of planners and solvers, to be had without loading the libraries that are behind them."""

from __future__ import annotations

PLANNERS = (
    "AORRTC",
    "BFMT",
    "BITstar",
    "BKPIECE1",
    "BiTRRT",
    "FMT",
    "InformedRRTstar",
    "KPIECE1",
    "LBKPIECE1",
    "PRM",
    "PRMstar",
    "RRT",
    "RRTConnect",
    "RRTstar",
    "SORRTstar",
)
"""What `planning.search.planners()` returns; a test compares them."""
SOLVERS = ("damped_least_squares", "trac_ik", "analytic")
"""The keys of `ik.SOLVERS`; likewise."""
