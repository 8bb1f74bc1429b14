"""Articulated objects, such as drawers and screw caps: `model` has what files say of them, `bodies` their physics."""
