"""Objects that tip over are told, and only those: MuJoCo says which ones fall."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kabo.geometry_server import GeometryServer, Situation, start_findings
from kabo.geometry_server.foresight.tipping import ROOM, tipping, tips_over
from kabo.language import load_problem
from kabo.meshes import Mesh, hull_of
from kabo.planner.solve import solve
from kabo.scene import Scene, attachment, load_scene
from kabo.verify import verify_plan
from tests.planner.gantry import gantry, gantry_problem

Walls = dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]]
BLOCK = ((0.2, 0.2, 0.1), (0.2, 0.0, 0.05))  # its sides are at x = 0.1 and 0.3


def scene_of(folder: Path, *, things: dict[str, tuple[float, float, float]], walls: Walls) -> Scene:
    described = gantry_problem(folder, things=things, walls=walls).scene
    assert described is not None
    return load_scene(described)


def falls(scene: Scene) -> bool:
    """Whether MuJoCo lets the cube fall from the block."""
    from kabo.simulation import Physics

    physics = Physics(scene)
    for _ in range(round(2.0 / physics.settings.timestep)):
        physics.step()
    return bool(physics.pose("cube")[2, 3] < 0.1)


def test_an_object_whose_middle_is_beside_its_support_is_told_with_the_distance(tmp_path: Path) -> None:
    described = gantry_problem(tmp_path, things={"cube": (0.306, 0.03, 0.12)}, walls={"block": BLOCK}).scene
    assert described is not None
    (only,) = start_findings(described)
    assert only.message == (
        "cube tips over at the start: the middle of its mass is 6 mm beside block, if its mass is spread evenly"
    )
    place = described.bodies["cube"].place
    assert place is not None and (only.line, only.column) == (place.line, place.column)


def test_what_stands_on_two_things_or_is_held_from_above_or_the_side_may_stay(tmp_path: Path) -> None:
    cube = {"cube": (0.306, 0.0, 0.12)}
    beside = {"block": BLOCK, "other": ((0.02, 0.2, 0.1), (0.325, 0.0, 0.05))}
    for walls, count in (
        ({"block": BLOCK}, 1),
        (beside, 0),
        ({"block": BLOCK, "wall": ((0.02, 0.2, 0.4), (0.3365, 0.0, 0.2))}, 0),
        ({"block": BLOCK, "lid": ((0.02, 0.2, 0.02), (0.29, 0.0, 0.1505))}, 0),
    ):
        assert len(tipping(scene_of(tmp_path, things=cube, walls=walls))) == count, walls


@pytest.mark.parametrize("x", [0.29, 0.298, 0.302, 0.31])
def test_what_is_told_falls_in_physics_and_the_others_stand(tmp_path: Path, x: float) -> None:
    pytest.importorskip("mujoco")
    scene = scene_of(tmp_path, things={"cube": (x, 0.0, 0.12)}, walls={"block": BLOCK})
    fallen = falls(scene)
    assert [each.name for each in tipping(scene)] == (["cube"] if fallen else [])
    assert fallen == (x > 0.3)


def test_the_middle_of_an_object_of_any_shape_counts_and_not_that_of_its_box(tmp_path: Path) -> None:
    """A pyramid's middle of mass lies at a quarter of the way from its base to its tip."""
    scene = scene_of(tmp_path, things={"cube": (0.29, 0.0, 0.12)}, walls={"block": BLOCK})
    assert tipping(scene) == []
    body, length = scene.bodies["cube"], 0.2
    corners = np.array([(-0.02, y, z) for y in (-0.02, 0.02) for z in (-0.02, 0.02)] + [(length, 0.0, -0.02)])
    faces = np.array([(0, 1, 3), (0, 3, 2), (1, 0, 4), (3, 1, 4), (2, 3, 4), (0, 2, 4)])
    for away, count in ((0.0, 1), (-0.05, 0)):  # the middle is at 0.29 - 0.02 + 0.055 + away
        mesh = Mesh(corners + (away, 0.0, 0.0), faces)
        changed = replace(scene, bodies={**scene.bodies, "cube": replace(body, mesh=mesh)})
        assert len(tipping(changed)) == count


def test_the_middle_of_an_open_surface_is_unknown_and_not_told(tmp_path: Path) -> None:
    scene = scene_of(tmp_path, things={"cube": (0.306, 0.0, 0.12)}, walls={"block": BLOCK})
    assert len(tipping(scene)) == 1
    body = scene.bodies["cube"]
    opened = replace(body, mesh=Mesh(body.mesh.vertices, body.mesh.faces[:-2]))
    assert tipping(replace(scene, bodies={**scene.bodies, "cube": opened})) == []


def let_go(scene: Scene, at: tuple[float, float, float]) -> bool:
    """Whether the cube is said to stay where a hand lets go of it."""
    surroundings = GeometryServer(scene).surroundings
    pose = np.eye(4)
    pose[:3, 3] = at
    found = tips_over(surroundings, Situation.of(scene.start), "cube", pose, "block")
    assert found is None or (found.carriers == ("block",) and found.metres > 0.0)
    return found is None


def test_what_is_put_down_beside_its_support_tips_over_unless_something_else_carries_it(
    tmp_path: Path,
) -> None:
    cube = {"cube": (-0.2, 0.3, 0.02)}
    beside = {"block": BLOCK, "other": ((0.02, 0.2, 0.1), (0.325, 0.0, 0.05))}
    wall = {"block": BLOCK, "wall": ((0.02, 0.2, 0.4), (0.3365, 0.0, 0.2))}
    alone, two, leaning = (
        scene_of(tmp_path, things=cube, walls=each) for each in ({"block": BLOCK}, beside, wall)
    )
    for x, wanted in (
        (0.29, (True, True, True)),
        (0.2965, (True, True, True)),
        (0.2985, (False, True, False)),  # too near to the edge for where a robot may put it
        (0.306, (False, True, False)),  # as near to the wall as a hair, which it may not touch
    ):
        assert tuple(let_go(each, (x, 0.0, 0.12)) for each in (alone, two, leaning)) == wanted, x


@pytest.mark.parametrize("seed", range(4))
def test_what_is_said_of_a_place_does_not_depend_on_places_before(tmp_path: Path, seed: int) -> None:
    """What a scene's bodies carry is kept as long as the scene is loaded."""
    random = np.random.default_rng(seed)
    described = gantry_problem(tmp_path, things={"cube": (-0.2, 0.3, 0.02)}, walls={"block": BLOCK}).scene
    assert described is not None
    used, said = GeometryServer(load_scene(described)).surroundings, set()
    for _ in range(40):
        angle, tilt = random.uniform(0.0, 6.3), random.choice([0.0, 1e-7, np.pi / 2, np.pi])
        turn = Rotation.from_euler("zx", [angle, tilt])
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = turn.as_matrix(), random.uniform([0.27, -0.1, 0.12], [0.32, 0.1, 0.12])
        fresh = GeometryServer(load_scene(described)).surroundings
        found = tips_over(used, Situation.of(used.scene.start), "cube", pose, "block")
        assert found == tips_over(fresh, Situation.of(fresh.scene.start), "cube", pose, "block")
        said.add(found is None)
    assert said == {True, False}


def test_what_is_put_down_beside_a_round_support_falls(tmp_path: Path) -> None:
    """A cube over a corner of the box around a cylinder stands on nothing."""
    scene = scene_of(tmp_path, things={"cube": (-0.2, 0.3, 0.02)}, walls={"block": BLOCK})
    turns = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
    ring = 0.1 * np.column_stack([np.cos(turns), np.sin(turns)])
    corners = np.vstack([np.column_stack([ring, np.full(48, z)]) for z in (-0.05, 0.05)])
    round_block = replace(scene.bodies["block"], mesh=hull_of(Mesh(corners, np.array([(0, 1, 2)]))))
    scene = replace(scene, bodies={**scene.bodies, "block": round_block})
    diagonal = np.sqrt(0.5)
    for away, wanted in ((0.09, True), (0.11, False), (0.135, False)):  # at 0.135 no corner is over it any more
        at = (0.2 + diagonal * away, diagonal * away, 0.12)
        assert let_go(scene, at) == wanted, away


@pytest.mark.parametrize("seed", range(3))
def test_a_place_that_reaches_over_an_edge_is_used_up_to_there(tmp_path: Path, seed: int) -> None:
    """The shelf is the region from x = -0.4 to -0.2; its support ends in its middle."""
    path = gantry(tmp_path, walls={"ledge": ((0.3, 0.4, 0.06), (-0.15, 0.0, 0.03))})
    scene = tmp_path / "scene.yaml"
    scene.write_text(scene.read_text().replace("support: table", "support: ledge"))
    problem = load_problem(path)
    plan = solve(problem, seed=seed).plan
    assert plan is not None
    (there,) = [node.after.objects["cube"] for node in plan.nodes.values() if node.action == "put" and node.after]
    assert there.parent == "world" and there.position[0] >= -0.3 + ROOM
    assert verify_plan(problem, plan).ok


def test_where_nothing_stands_the_reason_says_how_far_it_is_beside(tmp_path: Path) -> None:
    path = gantry(tmp_path, walls={"ledge": ((0.1, 0.4, 0.06), (-0.13, 0.0, 0.03))})
    scene = tmp_path / "scene.yaml"
    scene.write_text(scene.read_text().replace("support: table", "support: ledge"))
    result = solve(load_problem(path), max_samples=20_000)
    assert result.plan is None
    assert "cube would not stand: the middle of its mass is" in str(result.reason), str(result.reason)


@pytest.mark.parametrize("seed", range(8))
def test_boxes_of_any_size_and_turn_are_told_only_if_they_fall(tmp_path: Path, seed: int) -> None:
    pytest.importorskip("mujoco")
    random = np.random.default_rng(seed)
    size, angle, beside = random.uniform(0.02, 0.12, 3), random.uniform(0.0, np.pi), random.uniform(-0.012, 0.012)
    described = gantry_problem(tmp_path, walls={"block": BLOCK}).scene
    assert described is not None
    turned = np.eye(4)
    turned[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    turned[:3, 3] = 0.3 + beside, 0.0, 0.1 + size[2] / 2
    scene = load_scene(described)
    mesh = Mesh(scene.bodies["cube"].mesh.vertices / 0.04 * size, scene.bodies["cube"].mesh.faces)
    scene = replace(
        scene,
        bodies={**scene.bodies, "cube": replace(scene.bodies["cube"], mesh=mesh)},
        start=scene.start.replace({"cube": attachment("world", turned)}),
    )
    assert bool(tipping(scene)) == falls(scene) == (beside > 0.0)
    let_down = tips_over(GeometryServer(scene).surroundings, Situation.of(scene.start), "cube", turned)
    assert (let_down is not None) == (beside > -ROOM)
