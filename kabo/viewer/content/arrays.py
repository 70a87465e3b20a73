"""The arrays of a view document: one binary block, in which the document's references `{"array": k}` are looked up."""

from typing import Any

import numpy as np

TYPES = {"f4": "f32", "f8": "f64", "u2": "u16", "u4": "u32"}  # numpy's names, and those of the document
ALIGNMENT = 8  # bytes: what any typed array of a browser may begin at

Reference = dict[str, int]


class Arrays:
    """Arrays that are added one by one; equal ones are kept once."""

    def __init__(self) -> None:
        self._block = bytearray()
        self._table: list[dict[str, Any]] = []
        self._numbers: dict[tuple[str, bytes], int] = {}

    def add(self, array: Any) -> Reference:
        """A reference to an array of floats (32 or 64 bits) or of unsigned integers (16 or 32 bits), row by row.

        Raises:
            KeyError: elements are of another type.
        """
        flat = np.ascontiguousarray(array).ravel()
        kind, content = TYPES[flat.dtype.str[1:]], flat.astype(flat.dtype.newbyteorder("<")).tobytes()
        if (kind, content) not in self._numbers:
            self._block.extend(bytes(-len(self._block) % ALIGNMENT))
            self._numbers[kind, content] = len(self._table)
            self._table.append({"type": kind, "offset": len(self._block), "length": flat.size})
            self._block.extend(content)
        return {"array": self._numbers[kind, content]}

    @property
    def block(self) -> bytes:
        """All arrays, little-endian, each beginning at a multiple of eight bytes."""
        return bytes(self._block)

    @property
    def table(self) -> list[dict[str, Any]]:
        """The type, the first byte and the number of elements of each array, in the order of their references."""
        return list(self._table)
