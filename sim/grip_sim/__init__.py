"""The simulated world: SAPIEN in a process of its own, and adapters to GRIP's ports. Importing this loads no sapien."""
