"""Convex parts in files: beside a mesh file, to be distributed with it, and in kabo's cache.

Both kinds of files hold a line of JSON, then the vertices of all parts as little-endian float64. A file contains
the digest of the mesh's triangles in canonical order, so that parts are used only for the surface that they
enclose.
"""

import hashlib
import json
import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry.parts import COLUMNS, Enclosure

FORMAT = "kabo-parts/1"
METHOD_VERSION = 1  # to be incremented when the same mesh and tolerance give other parts
MAX_FILE_BYTES = 64 * 1024**2  # far more than the parts of any mesh need
MAX_HEADER_BYTES = 1024**2  # of the line of JSON


def canonical(vertices: Array, faces: Integers) -> tuple[Array, Integers]:
    """The vertices and faces of a mesh in canonical order, with equal vertices merged."""
    merged, index = np.unique(vertices + 0.0, axis=0, return_inverse=True)
    turned = index.reshape(-1)[faces]
    turned = np.take_along_axis(turned, (np.argmin(turned, axis=1)[:, None] + np.arange(3)) % 3, axis=1)
    proper = (turned[:, 0] != turned[:, 1]) & (turned[:, 1] != turned[:, 2]) & (turned[:, 2] != turned[:, 0])
    turned = turned[proper]
    return merged, turned[np.lexsort(turned.T[::-1])]


def digest_of(vertices: Array, faces: Integers) -> str:
    """The SHA-256 of a canonical mesh."""
    return hashlib.sha256(np.ascontiguousarray(vertices[faces], "<f8").tobytes()).hexdigest()


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


def read(path: Path, digest: str) -> dict[float, Enclosure]:
    """The stored enclosures of the mesh by tolerance [m]; none if the file is missing, foreign, old or damaged.

    Their claims about the mesh are verified elsewhere [kabo.geometry.bounding.verified_parts].
    """
    whole = read_whole(path)
    if whole is None:
        return {}
    header, numbers = whole
    try:
        if header["format"] != FORMAT or header["method"] != METHOD_VERSION or header["mesh"] != digest:
            return {}
        counts = [list(entry["vertices"]) for entry in header["entries"]]
        sizes = [count for entry in counts for count in entry]
        if not all(type(count) is int and 4 <= count <= COLUMNS for count in sizes):
            return {}
        if 3 * sum(sizes) != len(numbers):
            return {}
        parts = iter(np.split(numbers.reshape(-1, 3), np.cumsum(sizes)[:-1]))
        found = {}
        for entry, own in zip(header["entries"], counts, strict=True):
            made = Enclosure(tuple(next(parts).copy() for _ in own), float(entry["deviation"]))
            found[float(entry["tolerance"])] = made
        return found
    except (ValueError, KeyError, TypeError, OverflowError):
        return {}


def read_whole(path: Path) -> tuple[Any, Array] | None:
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


def write(path: Path, digest: str, enclosures: dict[float, Enclosure]) -> None:
    """Writes all enclosures of a mesh atomically; the same enclosures give the same bytes.

    Raises:
        OSError: the folder cannot be written.
    """
    ordered = sorted(enclosures.items())
    entries = [
        {"tolerance": tolerance, "deviation": made.deviation, "vertices": [len(part) for part in made.parts]}
        for tolerance, made in ordered
    ]
    body = b"".join(np.ascontiguousarray(part, "<f8").tobytes() for _, made in ordered for part in made.parts)
    header = {"format": FORMAT, "method": METHOD_VERSION, "mesh": digest, "entries": entries}
    write_whole(path, header, body)


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


def fitting(enclosures: dict[float, Enclosure], tolerance: float) -> Enclosure | None:
    """The enclosure with the fewest parts among those that deviate by at most the tolerance; None if there is none."""
    good = [made for made in enclosures.values() if made.deviation <= tolerance]
    return min(good, key=lambda made: (len(made.parts), -made.deviation), default=None)
