"""Bounding decompositions in the cache: files named by the content of the mesh and all parameters, written atomically.

A file is found by the mesh's arrays as given, which takes a millisecond, or by its triangles in canonical order.
"""

import hashlib
from pathlib import Path

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry.bounding.stored_parts import read_whole, write_whole

FORMAT = "kabo-decomposition/1"
METHOD_VERSION = 4  # to be incremented when the same mesh and parameters give other parts


def name_of(vertices: Array, faces: Integers, parameters: tuple[float | int | None, ...]) -> str:
    """The file name of a decomposition: the SHA-256 of the mesh's arrays, the parameters and the method."""
    digest = hashlib.sha256(repr((FORMAT, METHOD_VERSION, vertices.shape, faces.shape, parameters)).encode())
    digest.update(np.ascontiguousarray(vertices, "<f8").tobytes())
    digest.update(np.ascontiguousarray(faces, "<i8").tobytes())
    return digest.hexdigest()


def read(folder: Path, name: str) -> tuple[tuple[Array, ...], tuple[float, ...]] | None:
    """The parts and their deviations; None if the file is missing, foreign or damaged.

    Their claims about the mesh are verified elsewhere [kabo.geometry.bounding.verified_parts].
    """
    whole = read_whole(_file(folder, name))
    if whole is None:
        return None
    header, numbers = whole
    try:
        if header["format"] != FORMAT or header["name"] != name:
            return None
        counts = list(header["vertices"])
        if not all(type(count) is int and count >= 4 for count in counts):
            return None
        if 3 * sum(counts) + len(counts) != len(numbers):
            return None
        corners = np.split(numbers[: 3 * sum(counts)].reshape(-1, 3), np.cumsum(counts)[:-1])
        return tuple(corners), tuple(numbers[3 * sum(counts) :].tolist())
    except (ValueError, KeyError, TypeError, OverflowError):
        return None


def write(folder: Path, name: str, parts: tuple[Array, ...], deviations: tuple[float, ...]) -> None:
    """Writes parts and deviations atomically; the same parts give the same bytes.

    Raises:
        OSError: the folder cannot be written.
    """
    body = b"".join(np.ascontiguousarray(part, "<f8").tobytes() for part in parts)
    body += np.array(deviations, "<f8").tobytes()
    header = {"format": FORMAT, "name": name, "vertices": [len(part) for part in parts]}
    write_whole(_file(folder, name), header, body)


def _file(folder: Path, name: str) -> Path:
    return folder / f"{name[:40]}.decomposition"
