"""Bytes of messages as DDS and ROS 2 send them: CDR, little endian (OMG's common data representation, version 1)."""

import struct
from collections.abc import Sequence

ENCAPSULATION = b"\x00\x01\x00\x00"  # plain CDR, little endian, no options


class CdrWriter:
    """Appends values, each aligned to its size, counted from behind the four bytes of the encapsulation."""

    def __init__(self) -> None:
        self._body = bytearray()

    def content(self) -> bytes:
        """The whole message."""
        return ENCAPSULATION + bytes(self._body)

    def int32(self, value: int) -> None:
        """A signed number."""
        self._add("<i", 4, value)

    def uint32(self, value: int) -> None:
        """A number from 0 on."""
        self._add("<I", 4, value)

    def text(self, value: str) -> None:
        """A string: its length with the zero at its end, its bytes, the zero."""
        encoded = value.encode() + b"\0"
        self.uint32(len(encoded))
        self._body += encoded

    def texts(self, values: Sequence[str]) -> None:
        """A sequence of strings."""
        self.uint32(len(values))
        for value in values:
            self.text(value)

    def float64s(self, values: Sequence[float]) -> None:
        """A sequence of numbers of eight bytes; an empty one has no padding."""
        self.uint32(len(values))
        if values:
            self._align(8)
            self._body += struct.pack(f"<{len(values)}d", *values)

    def _add(self, form: str, size: int, value: int) -> None:
        self._align(size)
        self._body += struct.pack(form, value)

    def _align(self, size: int) -> None:
        self._body += bytes(-len(self._body) % size)
