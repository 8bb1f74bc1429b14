"""What all tests need: that Ctrl-C can be sent to the programs that they start."""

import signal


def pytest_configure() -> None:
    # A shell starts what it puts into the background with SIGINT ignored, and children inherit that. One with a
    # handler begins with the default again.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
