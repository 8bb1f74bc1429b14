"""The program of a recording process; see `recorder`."""

from .recorder import main

if __name__ == "__main__":
    main()
