"""What bounding meshes, bounding decompositions and bounded predicates reach, beside what they must.

    python benchmarks/geometry.py [SECTION …] [--judge-python PATH] [--output FOLDER] …

Sections: `bounding` (vertices, certificates and speed on closed meshes, outer and inner), `scaling` (10^3 to 10^6
triangles: seconds, memory, a chart), `compile` (a fresh process with an empty cache), `decomposition`, `predicates`
(bounded beside exact), `refused` (meshes that cannot be used, and what is said of them); without any, all of them.
Each prints tables and writes FOLDER/<section>.json, with the meshes and charts beside it.

The judge is `judge/evaluate.py` in a process and an environment of its own, which shares no code with kabo; without
`--judge-python` that environment is made once in kabo's cache folder from `judge/requirements.txt`. It also builds
the meshes, out of example-robot-data and constructive geometry. Nothing here is drawn at random but configurations
and the judge's samples, from fixed seeds. Needs the extras `robots` and `dev`.
"""

import argparse
import os
from collections.abc import Callable
from pathlib import Path

import geometry_judge
from geometry_figures import DECOMPOSITION_LIMITS, KNOWN
from table import Table, finish

SECTIONS = ("bounding", "scaling", "compile", "decomposition", "predicates", "refused")


def bounding(options: argparse.Namespace) -> list[Table]:
    """Closed meshes at 1 %, outer and inner."""
    from geometry_bounding import bounding_tables

    return bounding_tables(options.judge_python, options.meshes, options.output, options.only or list(KNOWN))


def scaling(options: argparse.Namespace) -> list[Table]:
    """Growth with the number of triangles."""
    from geometry_growth import growth_tables

    return growth_tables(options.output, options.largest)


def compile_(options: argparse.Namespace) -> list[Table]:
    """What compiling costs."""
    from geometry_growth import compile_table

    return [compile_table()]


def decomposition(options: argparse.Namespace) -> list[Table]:
    """Five meshes and a robot."""
    from geometry_decomposition import decomposition_tables

    names = options.only or list(DECOMPOSITION_LIMITS)
    return decomposition_tables(options.judge_python, options.meshes, options.output, names, options.robot)


def predicates(options: argparse.Namespace) -> list[Table]:
    """Bounded beside exact predicates."""
    from geometry_predicates import predicate_tables

    return predicate_tables(options.output, options.scene, options.configurations)


def refused(options: argparse.Namespace) -> list[Table]:
    """Meshes that cannot be used."""
    from geometry_refused import bad_table

    return [bad_table()]


RUN: dict[str, Callable[[argparse.Namespace], list[Table]]] = dict(
    zip(SECTIONS, (bounding, scaling, compile_, decomposition, predicates, refused), strict=True)
)


def main() -> None:
    """Measures what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", nargs="*", metavar="SECTION", help=f"of {', '.join(SECTIONS)}")
    parser.add_argument(
        "--judge-python", type=Path, metavar="PATH", help="an interpreter with the judge's packages"
    )
    parser.add_argument("--meshes", type=Path, metavar="FOLDER", help="the mesh set; built when it is not there")
    parser.add_argument("--output", type=Path, default=Path("geometry"), metavar="FOLDER")
    parser.add_argument("--only", nargs="+", metavar="MESH", help="bounding and decomposition: these meshes only")
    parser.add_argument("--largest", type=float, default=1e6, metavar="TRIANGLES", help="scaling: up to so many")
    parser.add_argument("--no-robot", dest="robot", action="store_false", help="decomposition: without the robot")
    parser.add_argument("--scene", choices=("both", "generated", "pandas"), default="both", help="predicates")
    parser.add_argument("--configurations", type=int, default=400, metavar="N", help="predicates: of each set")
    options = parser.parse_args()
    unknown = set(options.sections) - set(SECTIONS)
    if unknown:
        parser.error(f"no section {', '.join(sorted(unknown))}; there are {', '.join(SECTIONS)}")
    sections = [name for name in SECTIONS if name in options.sections or not options.sections]
    options.output.mkdir(parents=True, exist_ok=True)
    if {"bounding", "decomposition"} & set(sections):
        options.judge_python = geometry_judge.environment(options.judge_python)
        options.meshes = geometry_judge.mesh_set(options.judge_python, options.meshes)
    settings = {
        name: value
        for name, value in vars(options).items()
        if name in ("only", "largest", "scene", "configurations")
    }
    for section in sections:
        load = [round(value, 2) for value in os.getloadavg()]
        tables = RUN[section](options)
        finish(tables, options.output / f"{section}.json", section=section, load_before=load, **settings)


if __name__ == "__main__":
    main()
