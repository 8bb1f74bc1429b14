"""RGB-D cameras: what bodies look like, two renderers that see the same, sensor noise, and the rig of a world."""
