"""``python -m glue`` is ``peen``."""

import sys

from glue.cli import main

if __name__ == "__main__":
    sys.exit(main())
