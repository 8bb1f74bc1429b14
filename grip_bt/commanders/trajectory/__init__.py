"""Paths to trajectories: `timing` (a spline in time), `topp_ra` (the fastest velocities along it), `splines`.

`stopping` and `jerk_limited` bring motions to rest on their path, and on again; `limits` looks at what others timed.
"""
