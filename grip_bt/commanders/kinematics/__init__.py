"""Kinematics and collisions: `model` (a robot, and chains of its joints), `collision` with `shapes` and `outline`.

`ik` names the solvers for a `Target`: `damped_least_squares` (with an atlas of where to start), and TRAC-IK;
`fingertips` brings the tips of a hand to their places.
"""
