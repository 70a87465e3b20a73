"""`kabo bound`: simplifies a mesh to one that encloses it, or lies within it, at most epsilon away."""

import argparse
from typing import Any

from kabo.cli import exit_codes, rooms
from kabo.cli.limits import add_limits
from kabo.cli.mesh import meshing
from kabo.cli.terminal import clean_standard_output

NAME = "bound"
HELP = "simplify a mesh to one that encloses it (or lies within), no farther away than epsilon"
COSTS = ("memoryless", "planes", "adapted", "triangles", "diagonal")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo bound` to the parser."""
    meshing.add_mesh_arguments(parser)
    parser.add_argument(
        "--side",
        choices=("outer", "inner"),
        default="outer",
        help="enclose the mesh, or stay within it (default: outer)",
    )
    parser.add_argument(
        "--vertices", type=meshing.at_least(4), metavar="N", help="stop once there are no more than N vertices"
    )
    parser.add_argument("--cost", metavar="NAME", help=f"what is contracted first: {', '.join(COSTS)}")
    parser.add_argument(
        "--borders",
        choices=("refuse", "keep"),
        default="refuse",
        help="what to do with open borders (default: refuse)",
    )
    add_limits(parser)


def run(options: argparse.Namespace) -> int:
    """Writes the bounding mesh, checks that reading the file gives the same mesh, and prints its figures."""
    chosen: Any = {} if options.cost is None else {"cost": meshing.one_of("--cost", options.cost, COSTS)}
    loaded = meshing.load(options, borders=options.borders)
    mesh, epsilon = loaded.mesh, loaded.epsilon
    with clean_standard_output():
        made = rooms.bounding_mesh(
            mesh, epsilon, options.side, vertices=options.vertices, borders=options.borders, **chosen
        )
        rooms.write_mesh(options.output, made.vertices, made.faces)
        share = made.hausdorff_upper_bound / epsilon
        counts = f"{len(mesh.vertices)} to {len(made.vertices)} vertices"
        said = (
            f"{counts}, {options.side}, within {meshing.length(made.hausdorff_upper_bound)} ({share:.4f} epsilon)"
        )
        if options.picture is not None:
            surfaces = (mesh.vertices, mesh.faces), (made.vertices, made.faces)
            title = f"{options.mesh.name}: {said}"
            picture = rooms.bound_picture(*surfaces, epsilon=epsilon, title=title, wishes=rooms.ViewWishes())
            rooms.write_atomically(options.picture, picture)
    figures = {
        "vertices_in": len(mesh.vertices),
        "vertices_out": len(made.vertices),
        "faces_out": len(made.faces),
        "epsilon": epsilon,
        "hausdorff_upper_bound": made.hausdorff_upper_bound,
        "one_sided": made.one_sided,
        "contractions_per_s": made.contractions / max(made.contraction_seconds, 1e-9),
        "seconds": made.seconds,
    }
    meshing.finish(options, figures, loaded, f"{options.output}: {said}, {made.seconds:.1f} s")
    return exit_codes.DONE
