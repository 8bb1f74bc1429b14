"""The composition root: projects, which adapters a run gets, running tasks, and campaigns of runs."""
