"""`python -m grip_sim FD [HOLD]`: the simulator's process, started by `grip_sim.client` with open sockets."""

import os
import signal
import socket
import sys

from grip_sim.connection import ClosedError, pack, receive
from grip_sim.server import Server
from grip_sim.specs import WorldSpec


def main() -> int:
    """Make the world that the client asks for and obey it."""
    # Ctrl-C reaches the whole process group; when to end is the client's decision, and its end is ours.
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    connection = socket.socket(fileno=int(sys.argv[1]))
    try:
        fields, _ = receive(connection)
        hold = socket.socket(fileno=int(sys.argv[2])) if len(sys.argv) > 2 else None
        server = Server(connection, WorldSpec.from_json(fields["spec"]), fields["pace"], hold)
        connection.sendall(pack({"id": fields["id"], "time": 0.0}))
    except (ClosedError, BrokenPipeError):
        return 0
    server.serve()
    os._exit(0)  # nothing is left to be saved, and taking the physics apart would take half a second


if __name__ == "__main__":
    sys.exit(main())
