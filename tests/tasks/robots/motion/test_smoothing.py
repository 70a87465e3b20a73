"""Motion through several parts: corners as round as their proofs allow, proven with what the trajectory deviates."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

import kabo
from kabo.geometry.collision import collision_view
from kabo.geometry_server import LINE_DEVIATION, GeometryServer, Situation, Success, candidate, tool_frame
from kabo.language.formulas import GroundCall
from kabo.motion import Timed, rounded_path, timed_path
from kabo.planner.refine.legs import legs_of
from kabo.scene import motion_limits
from kabo.tasks.procedures import GeometricProcedures
from kabo.tasks.robots.motion import smoothing, timing
from kabo.tasks.robots.motion.curves import curves_of, finer_samples
from kabo.tasks.robots.motion.parts import MotionPart
from kabo.tasks.robots.motion.resting_strokes import CURVED
from kabo.tasks.robots.motion.routes import Route, route_of
from kabo.tasks.robots.motion.smoothing import Smoothed, deviation_of, smoothed, smoothed_within
from kabo.tasks.robots.motion.timing import groups_of, timed_group
from kabo.tasks.robots.scenes import configuration
from kabo.tasks.robots.timed_paths import TimedPath
from tests.tasks.conftest import DOMAINS, scene_of

PROBLEM = "bartender/four_bottles.yaml"
DEVIATION = 0.05


@cache
def group() -> list[MotionPart]:
    """The parts of a free way and an approach, which follow each other without a stop."""
    server = GeometricProcedures(GeometryServer(scene_of(PROBLEM)), (DOMAINS / PROBLEM).parent)
    start = Situation.of(server.scene.start)
    answer = server.call(GroundCall("pick", ("left", "bottle_1")), start)
    assert isinstance(answer, Success)
    legs = legs_of(server.server.context(), start, answer.motion)
    assert legs is not None
    return next(each for each in groups_of(leg.part for leg in legs) if len(each) > 1)


@cache
def made(deviation: float) -> Smoothed:
    part = group()[0]
    return smoothed(group(), motion_limits(part.scene.robot("left"), part.joints), deviation)


def dense() -> np.ndarray:
    return np.concatenate([timed.trajectory.sampled(1000.0).positions for timed in made(DEVIATION).parts])


def test_parts_follow_each_other_without_a_stop_and_end_at_rest() -> None:
    found = made(DEVIATION).parts
    for before, after in zip(found, found[1:], strict=False):
        assert before.times[-1] == after.times[0]
        assert before.waypoints[-1] == after.waypoints[0]
        for order in (0, 1, 2):
            ends = (
                before.trajectory.at(before.times[-1] - 1e-12, order),
                after.trajectory.at(after.times[0], order),
            )
            assert np.abs(ends[0] - ends[1]).max() < 1e-6
        assert np.abs(after.trajectory.at(after.times[0], 1)).max() > 0.01
    for timed, time in ((found[0], found[0].times[0]), (found[-1], found[-1].times[-1])):
        assert np.abs(timed.trajectory.at(time, 1)).max() < 1e-8
        assert np.abs(timed.trajectory.at(time, 2)).max() < 1e-6


def test_a_stroke_of_few_way_points_is_sampled_finer_along_the_line_of_its_tool() -> None:
    """A spline through few points leaves the line, and would be refused; the robot would stop at each of them."""
    whole = group()[-1]
    path = whole.stretch.waypoints
    part = replace(whole, stretch=replace(whole.stretch, waypoints=(path[0], path[len(path) // 2], path[-1])))
    found = finer_samples(part)
    assert found is not None and len(found) > len(part.rows)
    assert np.array_equal(found[[0, -1]], np.array(part.rows)[[0, -1]])
    robot = part.scene.robot("left")
    places = np.array([candidate(robot, q).pose(tool_frame(robot))[:3, 3] for q in found])
    unit = (places[-1] - places[0]) / np.linalg.norm(places[-1] - places[0])
    away = places - places[0] - ((places - places[0]) @ unit)[:, None] * unit
    assert np.linalg.norm(away, axis=1).max() < LINE_DEVIATION


def test_rounded_corners_are_faster_than_stops() -> None:
    rounded, stopping = (sum(timed.seconds for timed in made(d).parts) for d in (DEVIATION, 0.0))
    assert rounded < 0.95 * stopping


def test_a_straight_stroke_of_the_tool_is_passed_without_a_stop() -> None:
    """Its way points sample a curve; between chords the motion would have to slow down at each of them."""
    part = group()[-1]
    limits = motion_limits(part.scene.robot("left"), part.joints)
    assert len(part.rows) > 3 and curves_of([part]) == {0}
    curve = smoothed([part], limits, DEVIATION)
    chords = timed_path(route_of([part], 0.0).corners, limits)
    assert curve.stops == 0 and curve.parts[0].seconds < 0.6 * chords.passing[-1]


def test_the_motion_is_proven_where_it_really_is() -> None:
    """Each sample lies as near to its path as is said, and is free of collision by the bounded check."""
    for part, timed in zip(group(), made(DEVIATION).parts, strict=True):
        path, samples = np.array(timed.waypoints), timed.trajectory.sampled(200.0).positions
        workspace = part.scene.workspace("left")
        for q in samples:
            steps = np.diff(path, axis=0)
            shares = np.clip(((q - path[:-1]) * steps).sum(axis=1) / (steps**2).sum(axis=1), 0.0, 1.0)
            away = np.abs(q - path[:-1] - shares[:, None] * steps).max(axis=1).min()
            assert away <= timed.trajectory.deviation + 1e-9
            whole = np.array(part.stretch.start)
            whole[part.columns] = q
            assert workspace.first_hit(whole) is None


def test_it_stays_near_the_way_points_that_were_found() -> None:
    path = np.concatenate([np.array(part.rows) for part in group()])
    for q in dense()[::20]:
        a, steps = path[:-1], np.diff(path, axis=0)
        squares = np.maximum((steps**2).sum(axis=1), 1e-18)
        shares = np.clip(((q - a) * steps).sum(axis=1) / squares, 0.0, 1.0)
        assert np.linalg.norm(q - a - shares[:, None] * steps, axis=1).min() <= DEVIATION + 1e-4


def by_a_goal() -> tuple[list[MotionPart], np.ndarray]:
    """The parts of a motion by a goal that is aside of its way, and this goal."""
    way, *others = group()
    path = way.stretch.path
    aside = 0.5 * (path[0] + path[-1])
    aside[0] += 0.4
    corners = [configuration(q) for q in (path[0], aside, path[-1])]
    halves = [replace(way, stretch=replace(way.stretch, waypoints=(a, b))) for a, b in pairwise(corners)]
    return [*halves, *others], np.array(halves[0].rows[-1])


def nearest(parts: Sequence[TimedPath], goal: np.ndarray) -> float:
    rows = np.concatenate([timed.trajectory.sampled(1000.0).positions for timed in parts])
    return float(np.linalg.norm(rows - goal, axis=1).min())


def test_times_of_plans_pass_goals_nearer_than_other_corners(monkeypatch: pytest.MonkeyPatch) -> None:
    parts, goal = by_a_goal()
    assert 0.1 < nearest(timed_group(parts), goal) <= smoothing.AT_GOALS < smoothing.DEVIATION
    monkeypatch.setattr(timing, "AT_GOALS", 0.02)
    assert nearest(timed_group(parts), goal) <= 0.02


def test_where_the_base_drives_corners_are_passed_nearer(monkeypatch: pytest.MonkeyPatch) -> None:
    assert deviation_of(group()) == smoothing.DEVIATION
    monkeypatch.setattr(MotionPart, "drives", True)
    driving = [replace(part) for part in group()]
    assert deviation_of(driving) == smoothing.DRIVEN_DEVIATION < smoothing.DEVIATION


def test_where_a_part_ends_the_motion_passes_as_near_as_asked_and_elsewhere_as_far_as_it_may() -> None:
    parts, goal = by_a_goal()
    limits = motion_limits(parts[0].scene.robot("left"), parts[0].joints)
    seconds = []
    for at_goals in (np.inf, 0.1, 0.02):
        found = smoothed(parts, limits, 0.4, None, at_goals)
        away = nearest(found.parts, goal)
        assert away <= at_goals + 1e-4
        assert found.stops == 0
        seconds.append(found.parts[-1].times[-1])
        if at_goals == np.inf:
            assert away > 0.1
    assert seconds == sorted(seconds)
    assert seconds[0] < seconds[-1]


def test_next_to_the_object_the_motion_is_straight() -> None:
    """A curve of the joints has no curvature where the motion rests; its way points there are dense."""
    last = made(DEVIATION).parts[-1]
    rows = np.array(last.waypoints)
    samples = last.trajectory.at(np.linspace(last.times[-2], last.times[-1], 50))
    unit = (rows[-1] - rows[-2]) / np.linalg.norm(rows[-1] - rows[-2])
    away = samples - rows[-2] - ((samples - rows[-2]) @ unit)[:, None] * unit
    assert np.abs(away).max() < CURVED


@pytest.mark.parametrize("blocked", [False, True])
def test_where_nothing_is_proven_it_stops(monkeypatch: pytest.MonkeyPatch, blocked: bool) -> None:
    """With obstacles everywhere beside the path every blend is refused, and the motion stops at each corner."""
    part = group()[0]
    if blocked:
        monkeypatch.setattr(MotionPart, "proven_near", lambda _, starts, *__, **___: np.zeros(len(starts), bool))
    found = smoothed(group(), motion_limits(part.scene.robot("left"), part.joints), DEVIATION)
    inner = len(route_of(group(), 0.1 * DEVIATION).corners) - 2
    assert inner > 0
    assert found.stops == (inner if blocked else 0)


def test_rounds_that_reach_over_a_corner_bend_the_path_there() -> None:
    """A sharp turn between short pieces is rounded over its neighbours; to shrink theirs would change nothing."""
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.04], [0.99, 0.08], [0.99, 1.0]])
    route = Route((), corners, (0, 0, 0, 0), 0.0)
    path, trims = rounded_path(corners, deviation=0.1, shares=[1.0] * 5, chord=1e-3)
    after = path.passing[path.corners[2]]
    assert trims[1] > after - path.passing[path.corners[1]]
    assert route.bending(path, trims, np.array([[after, after + 0.01]])) == [1]
    gentle, less = rounded_path(corners, deviation=0.1, shares=[1.0, 1e-3, 1.0, 1.0, 1.0], chord=1e-3)
    assert 1 not in route.bending(gentle, less, np.array([[after, after + 0.01]]))


def test_what_is_surely_not_proven_of_a_path_is_not_timed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rounds shrink until the path is free, and only then a motion along it is made."""
    part, timed, routes, make = group()[0], list[Timed](), list[Route](), smoothing._timed

    def counted(*arguments: object) -> Timed:
        timed.append(make(*arguments))  # type: ignore[arg-type]
        return timed[-1]

    def found(*arguments: object) -> Route:
        routes.append(route_of(*arguments))
        return routes[-1]

    monkeypatch.setattr(smoothing, "_timed", counted)
    monkeypatch.setattr(smoothing, "route_of", found)
    monkeypatch.setattr(MotionPart, "proven_near", lambda _, starts, *__, **___: np.zeros(len(starts), bool))
    smoothed(group(), motion_limits(part.scene.robot("left"), part.joints), DEVIATION)
    assert len(timed) == len(routes) > 1  # with its curves, and with chords instead


def test_a_motion_that_is_too_slow_with_the_widest_rounds_is_not_proven(monkeypatch: pytest.MonkeyPatch) -> None:
    part, seconds = group()[0], made(DEVIATION).parts[-1].times[-1]
    limits, looked = motion_limits(part.scene.robot("left"), part.joints), list[object]()
    look = smoothing.Rounds.looked_at
    monkeypatch.setattr(smoothing.Rounds, "looked_at", lambda *given: looked.append(given) or look(*given))
    assert smoothed_within(group(), limits, DEVIATION, None, np.inf, 0.5 * seconds) is None
    assert not looked
    assert smoothed_within(group(), limits, DEVIATION, None, np.inf, seconds + 1e-3) == made(DEVIATION)
    assert looked


def test_no_round_takes_a_joint_out_of_its_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a rounded corner would leave the limits, it is rounded less."""
    parts = group()
    robot = parts[0].scene.robot("left")
    limits = motion_limits(robot, parts[0].joints)
    free = smoothed(parts, limits, DEVIATION)
    highest = max(
        part.trajectory.at(np.linspace(*part.times[:: len(part.times) - 1], 200)).max(axis=0)[0]
        for part in free.parts
    )
    upper = robot.tree.upper.copy()
    upper[0] = highest - 1e-6
    monkeypatch.setitem(vars(robot), "tree", robot.tree._replace(upper=upper))
    found = smoothed(parts, limits, DEVIATION).parts
    assert max(part.trajectory.bounds()[1][0] for part in found) <= upper[0] + 1e-9
    assert sum(part.seconds for part in found) > sum(part.seconds for part in free.parts)


def test_rounds_of_free_ways_divide_no_parts_of_bodies(monkeypatch):
    """With a fine epsilon finer parts would take seconds each; what keeps its shape may ask for them."""
    problem, epsilon = kabo.load_problem(DOMAINS / "circular_rearrange" / "n3.yaml"), 0.001
    asked = {"free": 0, "kept": 0}
    proven_near = MotionPart.proven_near

    def counted(part, *arrays, apart, early):
        assert not (early and (part.touches or part.stretch.exact))
        asked["free" if early else "kept"] += 1
        return proven_near(part, *arrays, apart=apart, early=early)

    def refused(*_):
        raise AssertionError("a part was divided")

    monkeypatch.setattr(MotionPart, "proven_near", counted)
    monkeypatch.setattr(collision_view, "refine", refused)
    plan = kabo.solve(problem, epsilon=epsilon).plan
    assert plan is not None and asked["free"] > 10 and asked["kept"] > 0
