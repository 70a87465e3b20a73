"""Memory that a process has freed and the C library keeps: programs that plan again and again give it back."""

import ctypes


def give_back() -> None:
    """Returns free memory to the operating system if the C library supports this (glibc)."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
