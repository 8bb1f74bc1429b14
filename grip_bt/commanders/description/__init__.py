"""Robots from the files that they ship with: URDF, xacro, SRDF, MJCF and MoveIt configuration packages.

`config` says what a project file may ask for, `load` makes a `RobotDescription` of it, `check` finds what is wrong.
"""
