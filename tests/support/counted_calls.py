"""How much work a call is, counted and not timed: the same number on every machine."""

import sys
from collections.abc import Callable
from contextlib import suppress

from kabo.errors import InputError


def calls_made(work: Callable[[], object], *, of_c: bool = False) -> int:
    """The Python functions called by ``work``, and with ``of_c`` those written in C too; refused input is work, too."""
    counted = {"call", "c_call"} if of_c else {"call"}
    calls = 0

    def count(_frame: object, event: str, _argument: object) -> None:
        nonlocal calls
        calls += event in counted

    before = sys.getprofile()
    sys.setprofile(count)
    try:
        with suppress(InputError):
            work()
    finally:
        sys.setprofile(before)
    return calls
