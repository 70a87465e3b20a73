"""MuJoCo, loaded where something is stepped; without it a message says how to install it."""

from typing import Any

from kabo.errors import Diagnostic, InputError


def mujoco() -> Any:
    """The package `mujoco`.

    Raises:
        InputError: it is not installed.
    """
    try:
        import mujoco as library
    except ImportError:
        text, hint = "simulation needs MuJoCo, which is not installed", 'pip install "kabo[simulation]"'
        raise InputError([Diagnostic("mujoco", 1, 1, text, hint)]) from None
    return library
