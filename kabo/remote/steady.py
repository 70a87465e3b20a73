"""Keeps the garbage collector away while robots move: a full collection stops all threads for up to half a second.

That is longer than either side may be silent. So what exists before is frozen, and collections wait for robots to rest.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager

from kabo.frozen_gc import frozen_gc


class Collections:
    """Says when collections may happen; `enabled` is whether they may at all."""

    def __init__(self) -> None:
        self.enabled = gc.isenabled()

    def wait_for_rest(self, *, moving: bool) -> None:
        """Lets collections happen, but while robots are `moving`."""
        if self.enabled and gc.isenabled() == moving:
            (gc.disable if moving else gc.enable)()

    def end(self) -> None:
        """Lets collections happen as before."""
        self.wait_for_rest(moving=False)


@contextmanager
def steady() -> Iterator[Collections]:
    """A context in which existing objects are frozen, and collections wait for robots to rest."""
    collections = Collections()
    try:
        with frozen_gc():
            yield collections
    finally:
        collections.end()
