"""The connection to ROS of a process: its bus, and the clients of services, actions and topics that live on it."""
