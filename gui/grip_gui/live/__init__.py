"""What runs beside the editor, looked at: topics, named messages of a server, components, the robot's joints."""
