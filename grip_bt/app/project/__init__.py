"""A project on disk: its files, its catalogue, and what is wrong with what it names."""
