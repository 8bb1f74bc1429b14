"""Reading a legacy file without running it: names, values, calls, and the containers that they make."""
