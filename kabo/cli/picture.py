"""`kabo picture`: draws a scene, a plan, a motion's sweep, a grasp's samples or a mesh, without a display."""

import argparse
import re
from collections.abc import Callable
from pathlib import Path

from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import output_file, whole
from kabo.cli.limits import add_limits
from kabo.cli.mesh import meshing
from kabo.cli.terminal import clean_standard_output, tell
from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.phases import phase

NAME = "picture"
HELP = "draw a scene, a plan, a run, what a motion sweeps, samples of a grasp, or a mesh, without a display"
ENDINGS = (".png", ".svg", ".gif")
SIZES = (64, 4096)  # of a picture: least and most pixels of a side
NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo picture` to the parser."""
    plans = "a plan (.png: its film strip; .gif: one branch; .svg: its graph)"
    others = "a task file (with --scene), a task's report, a mesh, the log of a run (with --problem)"
    what = f"a scene or problem file, {others}, or {plans}"
    parser.add_argument("what", type=Path, metavar="WHAT", help=what)
    parser.add_argument(
        "-o",
        dest="output",
        type=picture_file,
        required=True,
        metavar="FILE",
        help="the picture: .png, .svg or .gif",
    )
    _add_choices(parser)
    _add_view(parser)
    parser.add_argument(
        "--problem", type=Path, metavar="FILE", help="the problem of a plan (default: found near it), or of a run"
    )
    parser.add_argument("--domain", type=Path, metavar="FILE", help="the domain file of a problem in PDDL or PKS")
    parser.add_argument("--scene", type=Path, metavar="FILE", help="the scene of a task")
    parser.add_argument(
        "--scale", type=meshing.scale, default=1.0, metavar="S", help="of a mesh: metres per unit of its file"
    )
    add_limits(parser)


def _add_choices(parser: argparse.ArgumentParser) -> None:
    chosen = parser.add_mutually_exclusive_group()
    chosen.add_argument(
        "--branch",
        metavar="OUTCOMES",
        help="of a plan: the outcomes of a branch, separated by commas, or a node that it leads through (default: the "
        "branch with most motions)",
    )
    chosen.add_argument("--at", metavar="NODE", help="of a plan: the scene as it is after a node")
    chosen.add_argument("--sweep", metavar="NODE[:SEGMENT]", help="of a plan: what the motion of a node sweeps")
    chosen.add_argument("--samples", metavar="ROBOT:OBJECT.GRASP", help="of a scene: hands at samples of a grasp")
    parser.add_argument(
        "--solution", type=whole(1), metavar="N", help="of a task's report: which solution (default: the cheapest)"
    )
    parser.add_argument(
        "--epsilon",
        type=meshing.tolerance,
        metavar="E",
        help="of a mesh: bound it within E, in metres or as a share of its diagonal (1%%); of a sweep: its accuracy",
    )


def _add_view(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--camera", type=point, metavar="X,Y,Z", help="where the camera stands, in metres (default: a good side)"
    )
    parser.add_argument(
        "--look-at", type=point_or_name, metavar="WHERE", help="what fills the picture: a thing's name, or X,Y,Z"
    )
    parser.add_argument("--size", type=size, metavar="WxH", help="in pixels (default: as what is drawn needs)")
    parser.add_argument("--labels", action=argparse.BooleanOptionalAction, default=True, help="write names")


def run(options: argparse.Namespace) -> int:
    """Writes the picture, and says how large it is."""
    with clean_standard_output():
        view = rooms.ViewWishes(options.camera, options.look_at, options.size, options.labels)
        wishes = rooms.PictureWishes(
            problem=options.problem,
            domain=options.domain,
            scene=options.scene,
            branch=options.branch,
            at=options.at,
            sweep=options.sweep,
            samples=options.samples,
            solution=options.solution,
            epsilon=_metres(options.epsilon),
            scale=options.scale,
            view=view,
        )
        with phase("drawing"):
            picture = rooms.picture_of_file(options.what, options.output.suffix.lower(), wishes)
    rooms.write_atomically(options.output, picture)
    tell(f"{options.output}: {len(picture) / 1000:.0f} kB")
    return exit_codes.DONE


def _metres(tolerance: "meshing.Tolerance | None") -> "Callable[[rooms.Mesh | None], float] | None":
    """The function that gives epsilon for a mesh, or for none [m]."""
    if tolerance is None:
        return None

    def metres(mesh: "rooms.Mesh | None") -> float:
        if mesh is not None:
            return tolerance.metres(mesh)
        if tolerance.of_diagonal:
            said = "a share of the diagonal is for meshes"
            raise InputError([Diagnostic("--epsilon", 1, 1, said, "write metres: 0.01")])
        return tolerance.value

    return metres


def picture_file(text: str) -> Path:
    """Converts text to the path of a picture to be written."""
    path = output_file(text)
    if path.suffix.lower() not in ENDINGS:
        meant = did_you_mean(path.suffix.lower(), ENDINGS)
        hint = f"; {meant}" if meant else ""
        raise argparse.ArgumentTypeError(f"{text!r} does not end with .png, .svg or .gif{hint}")
    return path


def point(text: str) -> tuple[float, float, float]:
    """Converts text such as `1.2,0,0.8` to a point [m]."""
    if not _is_point(text):
        raise argparse.ArgumentTypeError(f"{text!r} is not a point: write three numbers in metres, as 1.2,0,0.8")
    x, y, z = (float(word) for word in text.split(","))
    return x, y, z


def point_or_name(text: str) -> "tuple[float, float, float] | str":
    """Converts text to a point [m] if it has commas; else it is a name."""
    return point(text) if "," in text else text


def _is_point(text: str) -> bool:
    return re.fullmatch(rf"\s*{NUMBER}\s*(?:,\s*{NUMBER}\s*){{2}}", text) is not None


def size(text: str) -> tuple[int, int]:
    """Converts text such as `1280x720` to a width and a height in pixels."""
    found = re.fullmatch(r"(\d{1,5})[x×](\d{1,5})", text.strip().lower())
    sides = (0, 0) if found is None else (int(found[1]), int(found[2]))
    if not all(SIZES[0] <= side <= SIZES[1] for side in sides):
        wanted = f"a size from {SIZES[0]}x{SIZES[0]} to {SIZES[1]}x{SIZES[1]} pixels, such as 1280x720"
        raise argparse.ArgumentTypeError(f"{text!r} is not {wanted}")
    return sides
