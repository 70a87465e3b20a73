"""Every format that kabo reads: sound files to begin with, and what reading one of them means.

Shipped files are seeds by reference; small ones of each kind lie in `corpus/`. A case is made from the seed's files,
one of which is changed, in a folder of its own.
"""

import io
import json
import os
import random
import shutil
from collections.abc import Callable, Mapping
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from tests.fuzz import commands, explorations, formulas
from tests.fuzz.mutations import mutated

HOME = Path(__file__).resolve().parents[2]
CORPUS = Path(__file__).parent / "corpus"
DOMAINS = (
    *("bomb_in_the_toilet", "btcs", "safes", "poisonous_liquid", "asking_bartender", "painted_doors", "medicate"),
    *("doors", "coloured_balls", "wumpus", "unix", "canadian_traveller", "stacked", "force_sensing", "bartender"),
)
MESHES = ("tetra.off", "tetra.obj", "tetra.stl", "tetra.ply", "binary.stl", "binary.ply", "tetra.glb", "tetra.dae")
OPENED = ("robot.urdf", "gripper.urdf", "robot.urdf", "scene.yaml", "tetra.off")
Draw = Callable[[bytes, random.Random], bytes]


@dataclass(frozen=True)
class Seed:
    """A sound file: where it stands in the workspace, and the file to ask for, which may name it."""

    target: Path  # relative to the workspace
    main: Path


@dataclass(frozen=True)
class Format:
    """A format: its seeds, how a case is read, and how much of all files is of it."""

    name: str
    seeds: tuple[Seed, ...]
    read: Callable[[Path, int], object]  # (the file, the number of the case)
    share: float
    draw: Draw | None = None  # else mutations


class Workspace:
    """Copies of all seeds in a folder, in which one file at a time is changed, read, and put back."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        shutil.copytree(CORPUS, folder / "corpus")
        shutil.copytree(
            HOME / "domains", folder / "domains", ignore=shutil.ignore_patterns("*.png", "__pycache__")
        )
        shutil.copytree(HOME / "examples", folder / "examples", ignore=shutil.ignore_patterns("__pycache__"))
        (folder / "meshes").symlink_to(HOME / "meshes")
        self._sound: dict[Path, bytes] = {}

    def sound(self, target: Path) -> bytes:
        """The bytes of a seed."""
        if target not in self._sound:
            self._sound[target] = (self.folder / target).read_bytes()
        return self._sound[target]

    def case(self, format: Format, number: int) -> tuple[Seed, bytes]:
        """The seed and the changed bytes of a case; the same for the same name and number."""
        rng = random.Random(f"{format.name}:{number}")
        seed = rng.choice(format.seeds)
        sound = self.sound(seed.target)
        if format.draw is not None:
            return seed, format.draw(sound, rng)
        return seed, mutated(sound, rng, [self.sound(other.target) for other in format.seeds[:8]])

    def read(self, format: Format, seed: Seed, content: bytes, number: int) -> None:
        """Reads a changed file, and puts the sound one back."""
        target = self.folder / seed.target
        try:
            target.write_bytes(content)
            format.read(self.folder / seed.main, number)
        finally:
            target.write_bytes(self.sound(seed.target))


# ------------------------------------------------------------------------------------------------ what reading means
def _problem(path: Path, number: int) -> None:
    from kabo.language import check_files, load_problem

    check_files([path])
    problem = load_problem(path)
    if number % 10 == 0 and problem.scene is None:
        from kabo.planner.solve import solve

        solve(problem, max_expansions=20, timeout=1.0)


def _checked(path: Path, number: int) -> None:
    from kabo.errors import InputError
    from kabo.language import check_files

    found = check_files([path])
    if found:
        raise InputError(found)


def _description(path: Path, number: int) -> None:
    from kabo.language import load_scene_description

    load_scene_description(path)


def _opened(path: Path, number: int) -> None:
    from kabo.geometry_server import GeometryServer
    from kabo.language import load_scene_description
    from kabo.scene import link_poses, load_scene, world_T

    scene = load_scene(load_scene_description(path))
    for name, robot in scene.robots.items():
        link_poses(robot, scene.start.robots[name])
    for name in scene.bodies:
        world_T(scene, scene.start, name)
    GeometryServer(scene)


def _mesh(path: Path, number: int) -> None:
    from kabo.meshes import examine, load_mesh, repaired, require_closed, units_warning

    mesh = load_mesh(path, repair=number % 2 == 0)
    examine(mesh)
    units_warning(mesh)
    repaired(mesh)
    require_closed(mesh)


def _parts(path: Path, number: int) -> None:
    from kabo.geometry.bounding import stored_parts
    from kabo.geometry.bounding.verified_parts import are_verified

    shape = _tetrahedron(path)
    for made in stored_parts.read(stored_parts.beside(path), shape.digest):
        are_verified(shape.solid, made)


@cache
def _tetrahedron(path: Path):  # type: ignore[no-untyped-def]
    from kabo.geometry.bounding.shapes import shape_of
    from kabo.meshes import load_mesh

    return shape_of(load_mesh(path))


def _plan(path: Path, number: int) -> None:
    from kabo.plan import describe, load_plan, plan_to_json

    plan = load_plan(path)
    plan_to_json(plan)
    if number % 4 == 0:
        describe(plan)


def _verified(path: Path, number: int) -> None:
    from kabo.requests import verify_file

    str(verify_file(path.parents[1] / "domains/medicate/n5.yaml", path, knowledge_only=True))


def _report(path: Path, number: int) -> None:
    from kabo.tasks.files.comparing import compare, describe_comparison
    from kabo.tasks.files.describing import describe_report
    from kabo.tasks.files.report_form import read_report
    from kabo.viewer.content.report_view import report_view

    report = read_report(path.read_bytes(), str(path))
    describe_report(report)
    report_view(report, None)
    sound = read_report((CORPUS / "report.json").read_bytes(), "report.json")
    describe_comparison(compare(report, sound))


def _task(path: Path, number: int) -> None:
    from kabo.tasks.core import directions, tree
    from kabo.tasks.files import load_task_file
    from kabo.tasks.files.reports import structure

    file = load_task_file(path)
    task = file.task(partly=True)
    flows, _ = directions(task)
    tree(task, flows)
    structure(file, task, flows)


def _message(path: Path, number: int) -> None:
    from kabo.service import messages

    content = path.read_bytes()
    for kind in (messages.SolveRequest, messages.Envelope, messages.CancelRequest):
        try:
            messages.read(kind, content)
        except messages.Unreadable as error:
            assert str(error)  # noqa: PT017


def _enclosed(path: Path, number: int) -> None:
    from kabo.geometry import enclosing_parts
    from kabo.meshes import load_mesh, outwards

    mesh, _ = outwards(load_mesh(path))
    if len(mesh.faces) <= 8 and mesh.diagonal > 0.0:
        cache = path.parent / "parts"
        enclosing_parts(mesh, 0.2 * mesh.diagonal, cache=cache)


def _command(path: Path, number: int) -> None:
    from kabo.cli.main import _asks_for_json, main

    said, told, here = io.StringIO(), io.StringIO(), Path.cwd()
    words = json.loads(path.read_bytes())
    try:
        os.chdir(path.parents[1])
        with redirect_stdout(said), redirect_stderr(told):
            code = main(words)
    except SystemExit as ended:  # of argparse
        code = ended.code if isinstance(ended.code, int) else 0
    finally:
        os.chdir(here)
    shown = f"{words}: {told.getvalue()[-600:]}"
    assert code in {0, 2, 3, 4, 5}, f"exit code {code}: {shown}"  # noqa: PT017
    assert "defect of kabo" not in told.getvalue(), shown
    if _asks_for_json(words) and "--help" not in words and "--version" not in words and code != 0:
        assert isinstance(json.loads(said.getvalue()), dict), f"no JSON object: {shown}"


def _words(sound: bytes, rng: random.Random) -> bytes:
    return json.dumps(commands.drawn(rng)).encode()


def _formula(sound: bytes, rng: random.Random) -> bytes:
    """The small domain with one formula drawn anew."""
    lines = sound.decode().split("\n")
    places = [at for at, line in enumerate(lines) if line.lstrip().startswith("- ")]
    at = rng.choice(places)
    indent = len(lines[at]) - len(lines[at].lstrip())
    text = formulas.formula(rng)
    lines[at] = " " * indent + "- " + (f'"{text}"' if rng.random() < 0.3 else text)
    return "\n".join(lines).encode()


# ------------------------------------------------------------------------------------------------ all formats
def _corpus(*names: str, main: str | None = None) -> tuple[Seed, ...]:
    return tuple(Seed(Path("corpus") / name, Path("corpus") / (main or name)) for name in names)


def _shipped(kind: str) -> tuple[Seed, ...]:
    """Domains, or problems, of the symbolic and geometric domains, each with the problem that reads it."""
    seeds = []
    for name in DOMAINS:
        folder = Path("domains") / name
        problems = sorted(
            path.name for path in (HOME / folder).glob("*.yaml") if path.name not in {"domain.yaml", "scene.yaml"}
        )
        seeds.append(Seed(folder / ("domain.yaml" if kind == "domain" else problems[0]), folder / problems[0]))
    return tuple(seeds)


def _tasks() -> tuple[Seed, ...]:
    files = [*sorted((HOME / "domains").glob("*/tasks/*.yaml")), *sorted((HOME / "examples").glob("*/task.yaml"))]
    seeds = [
        Seed(path.relative_to(HOME), path.relative_to(HOME)) for path in files if "turning_cube" not in path.parts
    ]
    return (*_corpus("task.yaml"), *seeds)


def _explorations() -> tuple[Seed, ...]:
    files = sorted([*(HOME / "examples").glob("*/exploration.yaml"), HOME / "examples/pick_and_place/reach.yaml"])
    return (
        *_corpus("exploration.yaml"),
        *(Seed(path.relative_to(HOME), path.relative_to(HOME)) for path in files),
    )


def _scenes() -> tuple[Seed, ...]:
    scenes = [
        Path("domains") / name / "scene.yaml" for name in ("bartender", "stacked", "force_sensing", "assembly")
    ]
    return (*_corpus("scene.yaml"), *(Seed(path, path) for path in scenes))


FORMATS: Mapping[str, Format] = {
    each.name: each
    for each in (
        Format("domain", (*_shipped("domain"), *_corpus("domain.yaml", main="problem.yaml")), _problem, 0.05),
        Format("problem", (*_shipped("problem"), *_corpus("problem.yaml")), _problem, 0.04),
        Format("formula", _corpus("domain.yaml"), _checked, 0.08, _formula),
        Format("scene", _scenes(), _description, 0.06),
        Format("opened", _corpus(*OPENED, main="scene.yaml"), _opened, 0.03),
        Format("task", _tasks(), _task, 0.1),
        Format("exploration", _explorations(), explorations.file, 0.035),
        Format("model", _corpus("model.jsonl"), explorations.model, 0.035),
        Format("pddl", _corpus("logistics.pddl", "clg.pddl"), _problem, 0.08),
        Format("pks", _corpus("pks_typed.xml", "pks_untyped.xml"), _problem, 0.08),
        Format("mesh", _corpus(*MESHES), _mesh, 0.16),
        Format("enclosed", _corpus(*MESHES[:4]), _enclosed, 0.004),
        Format("command", _corpus("words.json"), _command, 0.02, _words),
        Format("parts", _corpus("tetra.off.parts", main="tetra.off"), _parts, 0.08),
        Format("plan", _corpus("plan.json", "old_plan.json", "certified.json", "medicate.json"), _plan, 0.08),
        Format("verified", _corpus("medicate.json"), _verified, 0.01),
        Format("report", _corpus("report.json"), _report, 0.08),
        Format("message", _corpus("request.json"), _message, 0.12),
    )
}  # fmt: skip
