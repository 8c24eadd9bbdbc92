"""The program: `python -m leafwise`, and `leafwise` where the package is installed."""

import sys

from ._leafwise import command


def main() -> int:
    """Run the program on the command line; its exit code."""
    try:
        code, out, err = command(sys.argv[1:])
    except KeyboardInterrupt:
        return 130
    sys.stdout.write(out)
    sys.stderr.write(err)
    return code


if __name__ == "__main__":
    sys.exit(main())
