"""The command line: one file per command that parses, calls, prints and returns an exit code.

It holds no rule that another door would need; those live in the rooms below. Nothing heavy is imported before the
command is known, so that `kabo --help` answers at once.
"""

from kabo.cli.main import main

__all__ = ["main"]
