"""Planning: pure answers to `requests`, in a process of its own.

`service` asks the child `process`, `answer` finds whoever answers a request: `search` (OMPL's planners and those of
`tree_planners`, with `paths` and `budget`), `straight`, `through` way points, `grasps`, `steering_step`.
`checks` is what plans begin and end with; `continuous` tells whether motions are free all along.
"""
