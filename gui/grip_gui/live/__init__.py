"""What runs beside the editor, looked at: topics, named messages of a server, components, the robot's joints."""

from .window import RosWindow

__all__ = ["RosWindow"]
