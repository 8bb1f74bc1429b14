"""What goes over the wire: pydantic models, of which `python -m grip_gui.typescript` makes the page's types."""
