"""`python -m kabo` is `kabo`."""

import sys

from kabo.cli.main import main

if __name__ == "__main__":  # the guard is needed: worker processes import this file again
    sys.exit(main())
