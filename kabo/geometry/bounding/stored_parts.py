"""Convex parts in files: beside a mesh file, to be distributed with it, and in kabo's cache.

A file holds a line of JSON, then for each entry the corners of all parts and their deviations as little-endian
float64, at the size of the shape [kabo.geometry.bounding.shapes], whose digest it names. What it claims about the
shape is proven when it is read [kabo.geometry.bounding.verified_parts].
"""

import hashlib
import json
import os
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from kabo.arrays import Array

FORMAT = "kabo-parts/2"
METHOD_VERSION = 3  # part of the cache's keys; to be incremented when the same request gives other parts
MAX_FILE_BYTES = 64 * 1024**2  # far more than the parts of any mesh need
MAX_HEADER_BYTES = 1024**2  # of the line of JSON


@dataclass(frozen=True, eq=False)
class Cover:
    """Convex parts (V, 3) that cover a solid, and for each a proven upper bound of its points' distance from it."""

    parts: tuple[Array, ...]
    deviations: tuple[float, ...]
    tolerance: float  # which no deviation exceeds


def beside(mesh: Path) -> Path:
    """The path of the parts file of a mesh file: `<mesh>.parts`."""
    return mesh.with_name(f"{mesh.name}.parts")


def digest_beside(mesh: Path | None) -> str | None:
    """The SHA-256 of the parts file of a mesh file; None if it cannot be read."""
    if mesh is None:
        return None
    try:
        return hashlib.sha256(beside(mesh).read_bytes()).hexdigest()
    except OSError:
        return None


def read(path: Path, digest: str) -> list[Cover]:
    """The stored covers of a shape, the coarsest first; none if the file is missing, foreign, old or damaged."""
    whole = _read_whole(path)
    if whole is None:
        return []
    header, numbers = whole
    try:
        if header["format"] != FORMAT or header["shape"] != digest:  # any method's parts are proven when read
            return []
        found = [_cover(entry, numbers) for entry in header["entries"]]
        sizes = [sum(3 * len(part) + 1 for part in made.parts) for made in found]
        return found if sum(sizes) == len(numbers) else []
    except (ValueError, KeyError, TypeError, OverflowError, IndexError):
        return []


def _cover(entry: dict[str, Any], numbers: Array) -> Cover:
    """One entry of a file, whose numbers begin at `entry["first"]`."""
    counts, first, tolerance = list(entry["corners"]), entry["first"], float(entry["tolerance"])
    if not all(type(count) is int and 4 <= count <= len(numbers) for count in counts):
        raise ValueError("no numbers of corners")
    end = first + 3 * sum(counts)
    corners, deviations = numbers[first:end].reshape(-1, 3), numbers[end : end + len(counts)].tolist()
    if first < 0 or len(deviations) != len(counts) or not max(deviations) <= tolerance:
        raise ValueError("numbers are missing")
    parts = np.split(corners, np.cumsum(counts)[:-1])
    return Cover(tuple(part.copy() for part in parts), tuple(deviations), tolerance)


def write(path: Path, digest: str, covers: list[Cover]) -> None:
    """Writes covers of a shape atomically; the same covers give the same bytes.

    Raises:
        OSError: the folder cannot be written.
    """
    entries, body, first = [], [], 0
    for made in sorted(covers, key=lambda made: -made.tolerance):
        numbers = np.concatenate([*(part.reshape(-1) for part in made.parts), np.array(made.deviations)])
        counts = [len(part) for part in made.parts]
        entries.append({"tolerance": made.tolerance, "first": first, "corners": counts})
        body.append(np.ascontiguousarray(numbers, "<f8").tobytes())
        first += len(numbers)
    header = {"format": FORMAT, "method": METHOD_VERSION, "shape": digest, "entries": entries}
    write_whole(path, header, b"".join(body))


def _read_whole(path: Path) -> tuple[Any, Array] | None:
    """The JSON header and the numbers of a file written by `write_whole`; None if it is missing, huge or damaged."""
    try:
        if path.stat().st_size > MAX_FILE_BYTES:
            return None
        head, _, body = path.read_bytes().partition(b"\n")
        if len(head) > MAX_HEADER_BYTES:
            return None
        header = json.loads(head)
        if header["body"] != hashlib.sha256(body).hexdigest():
            return None
        return header, np.frombuffer(body, "<f8").astype(np.float64)
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None


def write_whole(path: Path, header: dict[str, Any], body: bytes) -> None:
    """Writes a file atomically: the header and the body's digest as a line of JSON, then the body.

    Raises:
        OSError: the folder cannot be written.
    """
    header = {**header, "body": hashlib.sha256(body).hexdigest()}
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=path.name)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(json.dumps(header, sort_keys=True).encode() + b"\n" + body)
        Path(name).chmod(0o644)
        Path(name).replace(path)
    finally:
        Path(name).unlink(missing_ok=True)
