"""The composition root: what puts a run together.

`project/`: a project's files, its catalogue, and what is wrong with them. `wiring/`: the robot backend (fakes,
simulation, ROS) and the other parts of a run. `runs/`: running, resuming, replaying, exporting. `campaign/`: many
runs, as a table. Each may import those before it.
"""
