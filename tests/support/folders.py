"""What a command has left in a folder."""

import os
from pathlib import Path


def written_in(folder: Path) -> list[str]:
    """The names of what a folder holds, in order; bytecode that Python keeps beside a script is nobody's result."""
    return sorted(name for name in os.listdir(folder) if name != "__pycache__")
