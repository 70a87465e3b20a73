"""What a process remembers between problems: values by the content that they follow from, bounded by bytes.

A worker of the service answers strangers one after the other, and each calls his files as he likes. So a key holds
*everything* that the value follows from, such as the bytes of a file, never its name, size or date: then an answer that
was remembered is the answer that would be computed [docs/decisions/026-worker-purity.md].
"""

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

ENTRY_BYTES = 512  # what an entry costs beside its value: key, tuples, places in dictionaries

_Value = TypeVar("_Value")


class Remembered(Generic[_Value]):
    """Values by keys; those asked for longest ago are forgotten first, so that all together have at most `max_bytes`.

    Args:
        max_bytes: of all values that are kept; a larger value is computed each time.
        size: the bytes of a value, at least about: it may grow by what it computes later.
    """

    def __init__(self, max_bytes: int, size: Callable[[_Value], int]) -> None:
        self._max_bytes, self._size = max_bytes, size
        self._lock = threading.Lock()
        self._values: OrderedDict[Hashable, tuple[_Value, int]] = OrderedDict()
        self._bytes = 0

    def of(self, key: Hashable, make: Callable[[], _Value]) -> _Value:
        """The value of a key: remembered, or made now; an error of `make` is raised and not remembered."""
        with self._lock:
            known = self._values.get(key)
            if known is not None:
                self._values.move_to_end(key)
                return known[0]
        value = make()  # without the lock: of two threads that make the same, the first one's is kept
        size = ENTRY_BYTES + self._size(value)
        with self._lock:
            if key not in self._values and size <= self._max_bytes:
                self._values[key] = value, size
                self._bytes += size
                while self._bytes > self._max_bytes:
                    self._bytes -= self._values.popitem(last=False)[1][1]
        return value

    def forget(self) -> None:
        """Forgets everything."""
        with self._lock:
            self._values.clear()
            self._bytes = 0

    def __len__(self) -> int:
        return len(self._values)

    @property
    def bytes(self) -> int:
        """The bytes of all values that are kept."""
        return self._bytes
