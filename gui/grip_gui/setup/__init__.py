"""The files that put a project together, for the page: read, checked, changed by forms, tried."""
