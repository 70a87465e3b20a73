"""What C++ libraries write to standard error, caught and read: urdfdom reports its errors nowhere else."""

import os
import re
import sys
import tempfile
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")

_PREFIX = re.compile(r"^\s*(Error|Warning|Scalar element .*?):?\s+|\s+at line \d+ in \S+$|\x1b\[[0-9;]*m")
_QUOTED = re.compile(r"'([^']+)'|\"([^\"]+)\"|\[([^\]]+)\]")


def with_messages(call: Callable[[], T]) -> tuple[T | None, list[str], str | None]:
    """The result of `call()`, the lines that it wrote to standard error, and its error as text (None: none).

    The file descriptor is redirected meanwhile, for all threads of this process.
    """
    sys.stderr.flush()
    saved = os.dup(2)
    result, reason = None, None
    with tempfile.TemporaryFile() as caught:
        os.dup2(caught.fileno(), 2)
        try:
            result = call()
        except (ValueError, RuntimeError) as error:
            reason = " ".join(str(error).split())
        finally:
            os.dup2(saved, 2)
            os.close(saved)
        caught.seek(0)
        text = caught.read().decode("utf-8", "replace")
    lines = (_PREFIX.sub("", line).strip() for line in text.splitlines())
    return result, [line for line in lines if line], reason


def names_in(line: str) -> list[str]:
    """The names that stand in quotes or brackets in a line of a C++ library."""
    return [next(filter(None, groups)) for groups in _QUOTED.findall(line)]
