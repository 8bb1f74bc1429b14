"""Planning: pure answers to `requests`, in a process of its own, which `service` starts and asks.

`answer` finds whoever answers a request, and makes steps of steered motions itself: `search` (OMPL's planners and those
of `tree_planners`, with `paths` and `budget`), `straight`, `through` way points, `grasps`. `checks` is what plans begin
and end with; `continuous` tells whether motions are free all along.
"""
