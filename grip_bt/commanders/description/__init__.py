"""Robots from the files that they ship with: URDF, xacro, SRDF, MJCF and MoveIt configuration packages.

`config` says what a project file may ask for, `load` makes a `RobotDescription` (`robot`) of it or finds a ready-made
one, `from_files` reads a robot's own files, `compose` puts robots together. `check_urdf` and `srdf` find what is wrong,
`build` and `roles` say what comes of it.
"""
