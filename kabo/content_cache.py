"""Caches shared by successive problems: values by the content that they are computed from, with a memory limit.

A worker of the service answers one client after the other, and different clients may give different files the same
name. So a key holds *everything* that its value depends on, such as the bytes of a file, never its name, size or date.
Then a cached value is the value that would be computed [docs/decisions/026-worker-purity.md].
"""

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

ENTRY_BYTES = 512  # what an entry costs beside its value: key, tuples, places in dictionaries

_Value = TypeVar("_Value")


class ContentCache(Generic[_Value]):
    """A cache that drops the least recently used values, so that all together have at most `max_bytes`.

    Args:
        max_bytes: the memory limit of all values together; a larger value is computed each time.
        size: the approximate size of a value [bytes]; a value may grow later, when it caches results of its own.
    """

    def __init__(self, max_bytes: int, size: Callable[[_Value], int]) -> None:
        self._max_bytes, self._size = max_bytes, size
        self._lock = threading.Lock()
        self._values: OrderedDict[Hashable, tuple[_Value, int]] = OrderedDict()
        self._bytes = 0

    def get_or_make(self, key: Hashable, make: Callable[[], _Value]) -> _Value:
        """The cached value of `key`, or else the value that `make` returns; errors of `make` are not cached."""
        with self._lock:
            known = self._values.get(key)
            if known is not None:
                self._values.move_to_end(key)
                return known[0]
        value = make()  # without the lock: if two threads make the same value, the first is kept
        size = ENTRY_BYTES + self._size(value)
        with self._lock:
            if key not in self._values and size <= self._max_bytes:
                self._values[key] = value, size
                self._bytes += size
                while self._bytes > self._max_bytes:
                    self._bytes -= self._values.popitem(last=False)[1][1]
        return value

    def clear(self) -> None:
        """Removes all values."""
        with self._lock:
            self._values.clear()
            self._bytes = 0

    def __len__(self) -> int:
        return len(self._values)

    @property
    def bytes(self) -> int:
        """The size of all values together [bytes]."""
        return self._bytes
