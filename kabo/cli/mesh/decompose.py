"""`kabo decompose`: covers a mesh with convex parts that stick out by at most epsilon."""

import argparse
from typing import Any

from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import natural
from kabo.cli.limits import add_limits
from kabo.cli.mesh import meshing
from kabo.cli.terminal import clean_standard_output

NAME = "decompose"
HELP = "cover a mesh with convex parts, no farther away than epsilon"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo decompose` to the parser."""
    meshing.add_mesh_arguments(parser)
    parser.add_argument("--parts", type=meshing.at_least(1), metavar="N", help="aim at N parts")
    parser.add_argument(
        "--vertices-per-part", type=meshing.at_least(4), metavar="N", help="aim at N vertices a part"
    )
    parser.add_argument(
        "--engine",
        choices=("kabo", "coacd"),
        default="kabo",
        help="what cuts the mesh: kabo, or CoACD, whose hulls are widened to cover it (default: kabo)",
    )
    parser.add_argument(
        "--seed", type=natural, default=0, metavar="N", help="the seed of CoACD's random choices (default: 0)"
    )
    add_limits(parser)


def run(options: argparse.Namespace) -> int:
    """Writes the parts as meshes, checks that reading the file gives the same parts, and prints their figures."""
    loaded = meshing.load(options)
    mesh, epsilon = loaded.mesh, loaded.epsilon
    with clean_standard_output():
        import numpy as np

        made = rooms.bounding_decomposition(
            mesh,
            epsilon,
            parts=options.parts,
            vertices_per_part=options.vertices_per_part,
            engine=options.engine,
            seed=options.seed,
        )
        hulls = [(np.asarray(part), rooms.hull_faces(np.asarray(part))) for part in made.parts]
        rooms.write_pieces(options.output, [(f"part_{number}", *hull) for number, hull in enumerate(hulls)])
        share = made.hausdorff_upper_bound / epsilon
        sizes = [len(part) for part in made.parts]
        counts = f"{len(sizes)} convex part{'' if len(sizes) == 1 else 's'}, {sum(sizes)} vertices"
        said = f"{counts}, within {meshing.length(made.hausdorff_upper_bound)} ({share:.4f} epsilon)"
        if options.picture is not None:
            title = f"{options.mesh.name}: {len(mesh.vertices)} vertices to {said}"
            surface = (mesh.vertices, mesh.faces)
            picture = rooms.parts_picture(surface, hulls, epsilon=epsilon, title=title, wishes=rooms.ViewWishes())
            rooms.write_atomically(options.picture, picture)
    worst = int(np.argmax(made.deviations))
    figures: dict[str, Any] = {
        "parts": len(sizes),
        "vertices": sum(sizes),
        "vertices_max": max(sizes),
        "epsilon": epsilon,
        "hausdorff_upper_bound": made.hausdorff_upper_bound,
        "covers": True,
        "seconds": made.seconds,
        "worst_part": {"number": worst, "deviation": float(made.deviations[worst]), "vertices": sizes[worst]},
    }
    meshing.finish(options, figures, loaded, f"{options.output}: {said}, {made.seconds:.1f} s")
    return exit_codes.DONE
