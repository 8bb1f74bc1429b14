"""YAML files with the place of everything in them: reading, writing, and pydantic models as their shape."""
