"""The `grip` command: one verb a file; each offers `add_options(parser)` and `run(args) -> exit status`."""
