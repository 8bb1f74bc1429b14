"""ROS 2: the only room that imports rclpy and message packages. Importing it loads neither.

* `client/`: the bus (one node and its thread), services, actions, topics; each call ends, whatever the server does.
* `component`, `components`, `process`: external components, their processes and their servers.
* `controllers/`: executors over ros2_control's controllers; `moveit/`: move_group as planner and executor.
* `sensing`, `frames`, `transforms`, `convert*`: from messages to values and back.
* `interfaces/`: interface packages read, and built where they aren't installed.
* `messages/`: named messages served and asked for; `served`: ports offered to others.
* `watchdog` and `watchdog_process`, `process_reaper`: what outlives a dead run, and ends what it had begun.
"""

from .environment import RosEnvironment, environment, prepare

prepare()

__all__ = ["RosEnvironment", "environment", "prepare"]
