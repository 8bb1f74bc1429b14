"""The `grip` command: of each verb `add_VERB(parser)`, for its options, and `run_VERB(args) -> exit status, if not 0`.

Exit status: 0 done with a success outcome, 1 invalid input, 2 usage, 3 done with a failure outcome, 4 error in a node
or a process, 130 stopped.
"""

DONE, INVALID, FAILURE, NODE_ERROR, STOPPED = 0, 1, 3, 4, 130
