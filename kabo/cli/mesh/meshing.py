"""Arguments and output shared by `bound` and `decompose`: the mesh, the tolerance, warnings and the picture."""

import argparse
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kabo.cli import rooms
from kabo.cli.argument_types import output_file
from kabo.cli.terminal import answer, print_json, tell, warn
from kabo.errors import Diagnostic, InputError, did_you_mean

UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "um": 1e-6, "µm": 1e-6}
PICTURES = (".png",)
FINEST = 1e-11  # of the largest coordinate: rounding takes some hundreds of units in its last place


@dataclass(frozen=True)
class Tolerance:
    """An epsilon as given on the command line: in metres, or as a share of the bounding box's diagonal."""

    value: float
    of_diagonal: bool

    def metres(self, mesh: "rooms.Mesh") -> float:
        """The tolerance for a mesh [m].

        Raises:
            InputError: epsilon is smaller than the rounding error of coordinates of this size.
        """
        epsilon = self.value * mesh.diagonal if self.of_diagonal else self.value
        farthest = float(abs(mesh.vertices).max())
        if epsilon < FINEST * farthest:
            said = f"{epsilon:g} m is finer than coordinates of {farthest:g} m are known"
            hint = f"ask for {FINEST * farthest:.1g} m or more, or move the mesh to its origin"
            raise InputError([Diagnostic("--epsilon", 1, 1, said, hint)])
        return epsilon


def add_mesh_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments for the mesh to read, the tolerance, and the file to write."""
    parser.add_argument("mesh", type=Path, metavar="MESH", help="a mesh file: STL, OBJ, PLY, OFF, DAE or GLB")
    parser.add_argument(
        "--epsilon",
        type=tolerance,
        required=True,
        metavar="E",
        help="how far the result may stick out or shrink: in metres, or as a share of the diagonal (1%%)",
    )
    parser.add_argument(
        "--scale", type=scale, default=1.0, metavar="S", help="metres per unit of the file: 0.001 for millimetres"
    )
    parser.add_argument("--repair", action="store_true", help="repair what can be repaired safely, and report it")
    parser.add_argument("--picture", type=picture_file, metavar="PNG", help="draw the mesh and the result (PNG)")
    parser.add_argument(
        "-o", dest="output", type=mesh_file, required=True, metavar="OUT", help="the result: .off, .ply or .obj"
    )
    parser.add_argument("--json", action="store_true", help="print the figures as one JSON object")


def tolerance(text: str) -> Tolerance:
    """Converts text to an epsilon, such as `0.002` (metres) or `1%` (of the diagonal); errors suggest a fix."""
    number = text.strip()
    share = number.endswith("%")
    value = _value(number.removesuffix("%").strip())
    if value is None or value <= 0.0 or (share and value > 100.0):
        hint = _meant(number)
        wanted = "a length above 0: write metres (0.002) or a share of the diagonal (1%)"
        raise argparse.ArgumentTypeError(f"{text!r} is not {wanted}{hint}")
    return Tolerance(value / 100.0 if share else value, share)


def _value(text: str) -> float | None:
    if not re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", text, re.IGNORECASE):
        return None
    value = float(text)
    return value if math.isfinite(value) else None


def _meant(text: str) -> str:
    """`; did you mean …?` for a decimal comma and for lengths with a unit."""
    pointed = text.replace(",", ".")
    found = re.fullmatch(r"([\d.eE+-]+)\s*(mm|cm|um|µm|m|percent|per cent|)\s*(%?)", pointed)
    if found is None or (value := _value(found[1])) is None or value <= 0.0:
        return ""
    share = bool(found[3]) or found[2].startswith("per")
    meant = f"{value:g}%" if share else f"{value * UNITS.get(found[2], 1.0):g}"
    return "" if meant == text else f"; did you mean {meant}?"


def at_least(least: int) -> Callable[[str], int]:
    """A function that converts text to a whole number, and rejects numbers below `least`."""

    def parsed(text: str) -> int:
        if not re.fullmatch(r"\d{1,12}", text) or int(text) < least:
            raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from {least} on")
        return int(text)

    return parsed


def scale(text: str) -> float:
    """Converts text to a scale [metres per unit]; the error for the name of a unit suggests its scale."""
    value = _value(text.strip())
    if value is None or value <= 0.0:
        named = {"mm": "0.001", "cm": "0.01", "m": "1", "inch": "0.0254", "in": "0.0254"}.get(text.strip().lower())
        hint = f"; did you mean {named}?" if named else ""
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of metres above 0{hint}")
    return value


def picture_file(text: str) -> Path:
    """Converts text to the path of a picture file to be written."""
    path = output_file(text)
    if path.suffix.lower() not in PICTURES:
        raise argparse.ArgumentTypeError(f"{text!r} does not end with .png")
    return path


def mesh_file(text: str) -> Path:
    """Converts text to the path of a mesh file to be written, in a format that keeps all digits."""
    path = output_file(text)
    try:
        rooms.require_written(path)
    except InputError as error:
        (found,) = error.diagnostics
        raise argparse.ArgumentTypeError(f"{text!r}: {found.message}; {found.hint}") from None
    return path


def one_of(name: str, text: str, known: Sequence[str]) -> str:
    """Returns `text` if it is one of the known words.

    Raises:
        InputError: `text` is not a known word; the message suggests the nearest one.
    """
    if text not in known:
        hint = did_you_mean(text, known) or f"kabo knows {', '.join(known)}"
        raise InputError([Diagnostic(name, 1, 1, f'there is no "{text}"', hint)])
    return text


@dataclass(frozen=True)
class Loaded:
    """The mesh of a command, its tolerance [m], the repairs that were made, and warnings."""

    mesh: "rooms.Mesh"
    epsilon: float
    repairs: tuple[str, ...]
    warnings: tuple[str, ...]


def load(options: argparse.Namespace, *, borders: str = "refuse") -> Loaded:
    """Loads, repairs (if requested) and checks the mesh of a command, so that it can be bounded.

    If a picture is requested, the library for pictures is checked before the mesh is loaded.

    Raises:
        MeshError: the mesh cannot be bounded; the message gives counts and the remedy.
        InputError: the library for pictures is missing.
    """
    if options.picture is not None:
        rooms.require_pictures("--picture")
    mesh = rooms.load_mesh(options.mesh, options.scale)
    repairs: list[str] = []
    if options.repair:
        mesh, repairs = rooms.repaired(mesh)
    for done in repairs:
        tell(f"{options.mesh}: {done}")
    rooms.require_solid(mesh, borders="keep" if borders == "keep" else "refuse", repair=options.repair)
    epsilon = options.epsilon.metres(mesh)
    warnings = [warning for warning in (rooms.units_warning(mesh), _crossing(mesh)) if warning is not None]
    for warning in warnings:
        warn(str(warning))
    return Loaded(mesh, epsilon, tuple(repairs), tuple(warning.message for warning in warnings))


def _crossing(mesh: "rooms.Mesh") -> Diagnostic | None:
    """A warning if faces cross: what they enclose counts as inside, but an inner mesh may miss some of it."""
    count = int(rooms.crossing_faces(mesh.vertices, mesh.faces).sum())
    if count == 0:
        return None
    said = f"{count} of {len(mesh.faces)} triangles cross others, and may still do so in the result"
    fix = "unite the pieces before, e.g. in MeshLab (Filters, Remeshing, Mesh Boolean: Union)"
    return Diagnostic(str(mesh.path), 1, 1, said, fix, severity="warning")


def finish(options: argparse.Namespace, figures: dict[str, Any], loaded: Loaded, said: str) -> None:
    """Prints the figures, as one JSON object or as a line of text."""
    answer(said)
    if options.json:
        print_json({**figures, "repairs": list(loaded.repairs), "warnings": list(loaded.warnings)})


def length(metres: float) -> str:
    """A length as text: `1.25 mm`."""
    return f"{metres * 1000:.3g} mm" if metres < 1.0 else f"{metres:.3g} m"
