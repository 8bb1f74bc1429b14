"""How robots are asked: descriptions, kinematics, collisions, planning, timing, and the commanders.

Nothing here knows ROS or a simulator: executors, hands and cameras are Protocols of `grip_bt.base.ports`. The heavy
libraries (pin, coal, OMPL, toppra) are imported by the modules that use them, never by this package itself.

`arm` and `hand` implement the ports by a planner and an executor. `joined` makes one arm of several, `steering` and
`steered_motion` steer, `pausing` pauses executors that can only stop, `scene` and `scene_file` say what is avoided.
"""
