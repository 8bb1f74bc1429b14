"""How robots are asked: descriptions, kinematics, collisions, planning, timing, and the commanders.

Nothing here knows ROS or a simulator. The heavy libraries (pin, coal, OMPL, toppra) are imported by the modules that
use them. `arm` and `hand` implement the ports by a planner and an executor.
"""
