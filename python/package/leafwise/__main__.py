"""The program: `python -m leafwise`, and `leafwise` where the package is installed."""

import sys

from ._leafwise import program


def main() -> int:
    """Run the program on the command line; its exit code."""
    try:
        return program(sys.argv[1:])
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main())
