"""The command line: one file per command that parses, calls, prints and returns an exit code.

Rules that the service and Python need as well are in the rooms that it calls. Nothing heavy is imported before the
command is known, so that `kabo --help` answers at once.
"""

from kabo.cli.main import main

__all__ = ["main"]
