"""What travels between the rooms: errors, values, operations, ports, YAML with places, expressions."""
