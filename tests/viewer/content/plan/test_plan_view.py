"""The view of a plan: every node once, hand-overs where the plan says, margins above what the certificate proves."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import Delaunay

import kabo
from kabo.plan import plan_from_json
from kabo.scene import link_poses
from kabo.viewer.content.arrays import Arrays
from kabo.viewer.content.plan.plan_view import plan_view

REPOSITORY = Path(__file__).parents[4]
N2 = REPOSITORY / "domains" / "stacked" / "n2.yaml"
DOORS = REPOSITORY / "domains" / "doors" / "n3.yaml"


@pytest.fixture(scope="module")
def stacked():
    problem = kabo.load_problem(N2)
    plan = kabo.solve(problem, seed=0).plan
    assert plan is not None
    scene = kabo.load_scene(problem.scene)
    return plan, scene, plan_view(plan, problem, scene, Arrays())


def test_every_node_has_a_box_and_every_edge_its_ends(stacked):
    plan, _scene, view = stacked
    assert {node["id"] for node in view["nodes"]} == set(plan.nodes)
    edges = {(edge["from"], edge["to"]) for edge in view["edges"]}
    assert edges == {(name, after) for name, node in plan.nodes.items() for after in node.successors}
    assert json.loads(json.dumps(view, allow_nan=False)) == view


def test_after_its_last_handover_an_object_is_where_the_plan_says(stacked):
    """The parent may be told otherwise (the world, or what it stands on), but not the place."""
    plan, scene, view = stacked
    seen = 0
    for node in view["nodes"]:
        for each in (node["motion"] or {"handovers": []})["handovers"]:
            told = plan.nodes[node["id"]].after.objects[each["object"]]
            last = [h for h in node["motion"]["handovers"] if h["object"] == each["object"]][-1]
            if last is each and told.parent == each["parent"]:
                assert each["position"] == pytest.approx(told.position, abs=1e-6)
                seen += 1
    assert seen >= 2
    assert scene.movable


def test_measured_margins_are_above_the_proven_clearances(stacked):
    _plan, _scene, view = stacked
    for node in view["nodes"]:
        if node["margin"]:
            proven = [each["clearance"] for each in node["clearances"] if each["clearance"] is not None]
            least = min(distance for _, distance, _ in node["margin"])
            times = [time for time, *_ in node["margin"]]
            assert times == sorted(times)
            assert times[-1] == pytest.approx(node["motion"]["duration"], abs=1e-4)
            assert least >= min(proven, default=0.0) - 1e-6
            assert all(0 <= pair < len(view["pairs"]) or pair == -1 for *_, pair in node["margin"])


def test_sweeps_contain_every_moving_link_at_every_moment(stacked):
    """Against the corners of the meshes themselves; a polyhedron of its own contains each link."""
    plan, scene, _view = stacked
    arrays = Arrays()
    problem = kabo.load_problem(N2)
    view = plan_view(plan, problem, scene, arrays, margins=False, sweeps=True)
    node = next(node for node in view["nodes"] if node["sweeps"])
    segment, sweep = plan.nodes[node["id"]].motion[0], node["sweeps"][0]
    solids = [Delaunay(corners) for corners in corners_of(sweep, arrays)]
    robot = scene.robots[segment.robot]
    q = dict(zip(robot.joint_names, scene.start.robots[robot.name], strict=True))
    for values in [*segment.waypoints, *segment.at(np.linspace(segment.times[0], segment.times[-1], 200))]:
        q.update(zip(segment.joints, values, strict=True))
        poses = link_poses(robot, tuple(q[name] for name in robot.joint_names))
        last = list(robot.links.values())[-1]
        points = last.mesh.vertices @ poses[last.name][:3, :3].T + poses[last.name][:3, 3]
        assert any(inside(points, solid) for solid in solids)
    assert not any(inside(points + (0.0, 0.0, 3.0), solid) for solid in solids)


def corners_of(sweep, arrays) -> list[np.ndarray]:
    """The polyhedra of a sweep, each by its corners [m]."""
    entry = arrays.table[sweep["corners"]["array"]]
    numbers = np.frombuffer(
        arrays.block, {"u16": "<u2", "u32": "<u4"}[entry["type"]], entry["length"], entry["offset"]
    )
    corners = np.array(sweep["origin"]) + sweep["step"] * numbers.reshape(-1, 3)
    return np.split(corners, np.cumsum(sweep["sizes"])[:-1])


def inside(points: np.ndarray, solid: Delaunay) -> bool:
    """Whether all points lie in a convex solid."""
    return bool((solid.find_simplex(points, tol=1e-6) >= 0).all())


def test_a_plan_whose_scene_lacks_what_it_moves_is_still_shown(stacked):
    plan, scene, _view = stacked
    spoilt = plan_from_json(kabo.plan_to_json(plan).replace(b'"mobile"', b'"nobody"'))
    view = plan_view(spoilt, kabo.load_problem(N2), scene, Arrays())
    assert view["knowledge"] is None
    assert all(node["margin"] is None for node in view["nodes"])


def test_a_plan_without_a_scene_has_knowledge_and_no_motion():
    problem = kabo.load_problem(DOORS)
    plan = kabo.solve(problem, seed=0).plan
    view = plan_view(plan, problem, None, Arrays())
    assert all(node["motion"] is None for node in view["nodes"])
    assert view["knowledge"]["nodes"][plan.root]["ways"] == 1
