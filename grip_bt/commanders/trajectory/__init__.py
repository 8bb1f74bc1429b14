"""Paths to trajectories: `timing` (TOPP-RA by the library toppra, a spline in time), `splines`.

`stopping` brings motions to rest on their path, and on again; `limits` looks at what others timed.
"""
