"""Draws the pictures of README files and documentation, without a display (extra `pictures`).

    python -m scripts.pictures [PICTURE …] [--plans FOLDER]

One table says which command draws which picture; without names all are drawn. Plans that pictures show are solved, and
kept in FOLDER if one is named: then only those that are missing there are solved.
"""

import argparse
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kabo.language import load_problem
from kabo.pictures import PictureWishes, ViewWishes, picture_of_file
from kabo.pictures.drawing import Drawing, Glass, Label, Solid
from kabo.pictures.panels import png, titled
from kabo.pictures.scenes import MOVABLE
from kabo.pictures.views import picture_of
from kabo.plan import load_plan, plan_to_json
from kabo.plan.description import call
from kabo.planner.solve import solve
from kabo.whole_files import write_atomically
from scripts.gearbox import COLLAR, SEAT, SHOULDER
from scripts.generate_meshes import GEARBOX
from scripts.mesh_files import triangles
from scripts.solids import HIGH

ROOT = Path(__file__).resolve().parent.parent


@dataclass(frozen=True)
class Row:
    """A picture: its file, the file that it is drawn of, and options of `kabo picture`; `plan`: of that problem's plan."""

    picture: str
    what: str
    options: tuple[str, ...] = ()
    plan: bool = False


# The problem of each domain whose plan its README shows; those of the second table have no geometry.
MOVING = {
    "domains/assembly": "gearbox",
    "domains/bartender": "four_bottles",
    "domains/circular_rearrange": "n3",
    "domains/force_sensing": "n2",
    "domains/inspection": "three_boxes_covered",
    "domains/stacked": "n3",
    "domains/waiter": "two_cups",
    "examples/lifting_a_bar": "problem",
    "examples/tiago_inspection": "problem",
    "examples/two_arms": "problem",
}
SYMBOLIC = {
    "domains/asking_bartender": "n3",
    "domains/bomb_in_the_toilet": "n3",
    "domains/btcs": "n4",
    "domains/canadian_traveller": "n3",
    "domains/coloured_balls": "n3_1",
    "domains/doors": "n3",
    "domains/elogistics": "n3",
    "domains/grid": "n3",
    "domains/logistics": "n3",
    "domains/medicate": "n5",
    "domains/painted_doors": "n3",
    "domains/poisonous_liquid": "n2",
    "domains/rovers": "n4",
    "domains/safes": "n3",
    "domains/unix": "n1",
    "domains/wumpus": "n4",
}
SHOWN = {**MOVING, **SYMBOLIC}
# Scenes show another problem where it has more to see.
SCENES = {
    "domains/circular_rearrange": "n5",
    "domains/force_sensing": "n6",
    "domains/stacked": "n6",
}
TASKS = ("bottle_pouring", "pick_and_place", "retract_transit_approach", "turning_cube")


def _rows() -> tuple[Row, ...]:
    rows = []
    for folder, name in MOVING.items():
        problem = f"{folder}/{name}.yaml"
        rows.append(Row(f"{folder}/scene.png", f"{folder}/{SCENES.get(folder, name)}.yaml"))
        rows.append(Row(f"{folder}/plan.png", problem, plan=True))
    rows += [Row(f"{folder}/plan.svg", f"{folder}/{name}.yaml", plan=True) for folder, name in SHOWN.items()]
    rows += [Row(f"examples/{name}/scene.png", f"examples/{name}/scene.yaml") for name in TASKS]
    bartender, tap = "domains/bartender/four_bottles.yaml", "meshes/tap/tap.stl"
    rows += [
        Row("docs/pictures/bound.png", tap, ("--epsilon", "1%")),
        Row("docs/pictures/swept_volume.png", bartender, ("--sweep", "pick_up(o=bottle_2, r=right)"), plan=True),
        Row("docs/pictures/grasps.png", bartender, ("--samples", "left:bottle_2.side")),
        Row("docs/pictures/two_cans.png", "examples/two_cans/scene.yaml"),
        Row("docs/pictures/branch.gif", "domains/stacked/n3.yaml", plan=True),
    ]
    return tuple(rows)


TABLE = _rows()
# Charts, and pictures of things that no scene holds, have programs of their own.
PROGRAMS = {
    "docs/pictures/run.gif": "scripts.picture_run",
    "docs/pictures/simulations.png": "scripts.picture_simulations",
    "docs/pictures/viewer.png": "scripts.picture_viewer",
    "docs/pictures/sampling.png": "scripts.picture_sampling",
    "docs/pictures/exploration.png": "scripts.picture_exploration",
    "examples/lifting_a_bar/explored.png": "scripts.picture_lifting_a_bar",
    "examples/plucked_string": "scripts.exploration_figures",
    "docs/pictures/architecture.svg": "scripts.rooms",
}
GEARBOX_PICTURE = "domains/assembly/gearbox.png"
NAMES = (*(row.picture for row in TABLE), GEARBOX_PICTURE, *PROGRAMS)


def plan_of(problem: str, plans: Path) -> Path:
    """The file of a problem's plan in a folder; it is solved if it is not there."""
    path = plans / f"{problem.removesuffix('.yaml').replace('/', '-')}.json"
    if not path.exists():
        plan = solve(load_problem(ROOT / problem)).plan
        assert plan is not None, f"{problem} has no plan"
        write_atomically(path, plan_to_json(plan))
    return path


def drawn(row: Row, plans: Path) -> bytes:
    """The bytes of a picture of the table."""
    if row.picture.endswith(".svg") or row.plan:
        return _drawn(row, plan_of(row.what, plans), ("--problem", row.what, *row.options))
    return _drawn(row, ROOT / row.what, row.options)


def _drawn(row: Row, what: Path, options: tuple[str, ...]) -> bytes:
    given = dict(zip(options[::2], options[1::2], strict=True))
    epsilon = given.get("--epsilon")
    wishes = PictureWishes(
        problem=ROOT / given["--problem"] if "--problem" in given else None,
        sweep=_node(given["--sweep"], what) if "--sweep" in given else None,
        samples=given.get("--samples"),
        epsilon=None if epsilon is None else lambda mesh: 0.01 * float(epsilon.removesuffix("%")) * mesh.diagonal,
    )
    return picture_of_file(what, Path(row.picture).suffix, wishes)


def _node(call_text: str, plan_file: Path) -> str:
    """The first node of a plan that does this."""
    plan = load_plan(plan_file)
    return next(name for name, node in plan.nodes.items() if call(node) == call_text)


def gearbox() -> bytes:
    """The parts of the gearbox apart on their axis, and put together under a pipe of glass, as PNG."""
    apart = (("tree", 0.0, 0), ("bearing", 0.165, 1), ("pipe", 0.22, 2), ("bearing", 0.375, 3))
    together = (("tree", 0.0, 0), ("bearing", SHOULDER, 1), ("pipe", COLLAR, 2), ("bearing", COLLAR + SEAT, 3))
    solids, glass, labels = [], [], []
    for y, lifted, places in ((0.0, 0.0, apart), (0.22, 0.12, together)):
        for number, (part, z, colour) in enumerate(places):
            pose = np.eye(4)
            pose[1:3, 3] = y, z + lifted
            solid = Solid(f"{part} {number} {y}", *triangles(GEARBOX[part](HIGH)), MOVABLE[colour], pose)
            (glass if part == "pipe" and y else solids).append(solid)
            if not y:
                labels.append(Label(part, pose[:3, 3], MOVABLE[colour], about=frozenset([solid.name])))
    drawing = Drawing(tuple(solids), (Glass(tuple(glass), 0.4),), labels=tuple(labels))
    view = ViewWishes(camera=(1.4, 0.11, 0.8))
    return png(titled(picture_of(drawing, view), "A gearbox: its parts on their axis, and put together"))


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pictures", nargs="*", metavar="PICTURE", help="of the table; all without a name")
    parser.add_argument("--plans", type=Path, metavar="FOLDER", help="where plans are kept")
    options = parser.parse_args()
    chosen = options.pictures or list(NAMES)
    if unknown := sorted(set(chosen) - set(NAMES)):
        parser.error(f"no picture is called {', '.join(unknown)}; the table has {', '.join(NAMES)}")
    with tempfile.TemporaryDirectory() as folder:
        plans = options.plans or Path(folder)
        plans.mkdir(parents=True, exist_ok=True)
        for name in chosen:
            write(name, plans.resolve())


def write(name: str, plans: Path) -> None:
    """Writes one picture, and says so."""
    rows = {row.picture: row for row in TABLE}
    if name in PROGRAMS:
        subprocess.run([sys.executable, "-m", PROGRAMS[name]], cwd=ROOT, check=True)
    else:
        picture = gearbox() if name == GEARBOX_PICTURE else drawn(rows[name], plans)
        (ROOT / name).parent.mkdir(parents=True, exist_ok=True)
        write_atomically(ROOT / name, picture)
    print(name, flush=True)


if __name__ == "__main__":
    main()
