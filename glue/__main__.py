"""``peen``, and ``python -m glue``: the command, quiet from its first import on when Ctrl-C comes."""

from __future__ import annotations

import sys


def main() -> int:
    """Run the command line of this process and return its exit code."""
    try:
        from glue.cli import main as command  # here: what it imports takes long enough to be interrupted

        return command()
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main())
