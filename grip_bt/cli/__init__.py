"""The `grip` command: one verb a file; each offers `add_parser(subparsers)` and `run(args) -> exit status`."""
