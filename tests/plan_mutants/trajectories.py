"""Mutants of trajectories: coefficients, times, deviations, limits; each is wrong by more than files are rounded by."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from kabo.language.scene_description import RateLimit, RateLimits
from kabo.motion import Trajectory
from kabo.plan import Plan, Segment
from tests.plan_mutants.core import Case, mutation, pick

SURE = 1e-7  # [rad, m; or per s, per s2] of a jump: a hundred times what is accepted
FAST = 0.02  # [rad/s or m/s] of a joint where times are spoilt


def a_followed_segment(case: Case, rng: np.random.Generator, fits: Callable[[Segment], bool] = lambda s: True):
    """A segment with a trajectory that moves, its node and number."""
    found = [
        (name, i, segment)
        for name, i, segment in case.segments()
        if segment.trajectory is not None and np.ptp(segment.waypoints, axis=0).any() and fits(segment)
    ]
    return pick(rng, found)


def with_trajectory(case: Case, name: str, i: int, **changes) -> Plan:
    """The plan with the trajectory of one segment changed."""
    segment = case.plan.nodes[name].motion[i]
    assert segment.trajectory is not None
    return case.with_segments(name, {i: replace(segment, trajectory=replace(segment.trajectory, **changes))})


def with_coefficients(own: Trajectory, changes: dict[tuple[int, int], tuple[float, ...]]) -> dict:
    """The change of some polynomials of a trajectory, by piece and joint."""
    pieces = [list(piece) for piece in own.coefficients]
    for (k, j), coefficients in changes.items():
        pieces[k][j] = coefficients
    return {"coefficients": tuple(map(tuple, pieces))}


def _one_coefficient(case: Case, rng: np.random.Generator, power: int) -> Plan | None:
    found = a_followed_segment(case, rng)
    if found is None:
        return None
    name, i, segment = found
    own = segment.trajectory
    k, j = int(rng.integers(len(own.coefficients))), int(rng.integers(len(own.joints)))
    length = own.times[k + 1] - own.times[k]
    # At the end of the piece its position is off by this, so that it jumps, or misses the end of its path.
    off = float(rng.choice([-1.0, 1.0])) * SURE * 10.0 ** rng.uniform(0.0, 5.0)
    powers = [*own.coefficients[k][j], *[0.0] * 6][:6]
    powers[power] += off / length**power
    return with_trajectory(case, name, i, **with_coefficients(own, {(k, j): tuple(powers)}))


@mutation
def another_position_of_a_piece(case, rng):
    """It begins where the one before does not end."""
    return _one_coefficient(case, rng, 0)


@mutation
def another_velocity_of_a_piece(case, rng):
    """Its linear coefficient."""
    return _one_coefficient(case, rng, 1)


@mutation
def another_acceleration_of_a_piece(case, rng):
    """Its quadratic coefficient."""
    return _one_coefficient(case, rng, 2)


@mutation
def another_cubic_coefficient(case, rng):
    """Of any piece and joint."""
    return _one_coefficient(case, rng, 3)


@mutation
def another_quartic_coefficient(case, rng):
    """Of any piece and joint."""
    return _one_coefficient(case, rng, 4)


@mutation
def another_quintic_coefficient(case, rng):
    """Of any piece and joint."""
    return _one_coefficient(case, rng, 5)


@mutation
def a_coefficient_that_is_no_number(case, rng):
    """Not finite."""
    found = a_followed_segment(case, rng)
    if found is None:
        return None
    name, i, segment = found
    own = segment.trajectory
    place = int(rng.integers(len(own.coefficients))), int(rng.integers(len(own.joints)))
    return with_trajectory(case, name, i, **with_coefficients(own, {place: (float("nan"),)}))


@mutation
def two_joints_exchanged(case, rng):
    """In one piece of a trajectory; they differ."""
    found = a_followed_segment(case, rng)
    if found is None:
        return None
    name, i, segment = found
    own = segment.trajectory
    k = int(rng.integers(len(own.coefficients)))
    rows = own.coefficients[k]
    pairs = [(a, b) for a in range(len(rows)) for b in range(a) if abs(rows[a][0] - rows[b][0]) > SURE]
    if not pairs:
        return None
    a, b = pick(rng, pairs)
    return with_trajectory(case, name, i, **with_coefficients(own, {(k, a): rows[b], (k, b): rows[a]}))


@mutation
def a_piece_left_out(case, rng):
    """Of a trajectory; the one before lasts longer."""
    found = a_followed_segment(case, rng, lambda s: len(s.trajectory.coefficients) > 1)
    if found is None:
        return None
    name, i, segment = found
    own = segment.trajectory
    k = int(rng.integers(1, len(own.coefficients)))
    pieces, times = list(own.coefficients), list(own.times)
    moved = [abs(a[0] - b[0]) for a, b in zip(pieces[k - 1], pieces[k], strict=True)]
    if max(moved) < 1e-3:
        return None
    del pieces[k], times[k]
    return with_trajectory(case, name, i, coefficients=tuple(pieces), times=tuple(times))


def _fast_knots(segment: Segment) -> list[int]:
    own = segment.trajectory
    inner = range(1, len(own.times) - 1)
    return [k for k in inner if np.abs(own.at(own.times[k], 1)).max() > FAST]


@mutation
def another_time_between_two_pieces(case, rng):
    """By a tenth of a millisecond or more, where the motion is fast."""
    found = a_followed_segment(case, rng, _fast_knots)
    if found is None:
        return None
    name, i, segment = found
    times = list(segment.trajectory.times)
    k = pick(rng, _fast_knots(segment))
    room = min(times[k] - times[k - 1], times[k + 1] - times[k])
    times[k] += float(rng.choice([-1.0, 1.0])) * float(rng.uniform(min(1e-4, room / 4), room / 2))
    return with_trajectory(case, name, i, times=tuple(times))


@mutation
def a_trajectory_that_ends_late(case, rng):
    """After its segment."""
    found = a_followed_segment(case, rng)
    if found is None:
        return None
    name, i, segment = found
    times = segment.trajectory.times
    return with_trajectory(case, name, i, times=(*times[:-1], times[-1] + float(rng.uniform(1e-5, 0.5))))


@mutation
def a_way_point_passed_at_another_time(case, rng):
    """By a millisecond or more, where the motion is fast and states hardly a deviation."""

    def fast(segment):
        return [
            k
            for k in range(1, len(segment.times) - 1)
            if np.abs(segment.trajectory.at(segment.times[k], 1)).max() * 1e-3
            > 10.0 * segment.trajectory.deviation
            and min(np.diff(segment.times)[k - 1 : k + 1]) > 4e-3
        ]

    found = a_followed_segment(case, rng, fast)
    if found is None:
        return None
    name, i, segment = found
    times, k = list(segment.times), pick(rng, fast(segment))
    room = min(times[k] - times[k - 1], times[k + 1] - times[k])
    times[k] += float(rng.choice([-1.0, 1.0])) * float(rng.uniform(1e-3, room / 2))
    return case.with_segments(name, {i: replace(segment, times=tuple(times))})


@mutation
def a_way_point_that_the_trajectory_does_not_pass(case, rng):
    """An inner one is farther away than the deviation says."""
    found = a_followed_segment(case, rng, lambda s: len(s.waypoints) > 2)
    if found is None:
        return None
    name, i, segment = found
    k, j = int(rng.integers(1, len(segment.waypoints) - 1)), int(rng.integers(len(segment.joints)))
    rows = [list(row) for row in segment.waypoints]
    rows[k][j] += float(rng.choice([-1.0, 1.0])) * (
        4.0 * segment.trajectory.deviation + 10.0 ** rng.uniform(-6, -2)
    )
    path = tuple(map(tuple, rows))
    own = replace(segment.trajectory, waypoints=path)
    moved = replace(segment, waypoints=path, trajectory=own)
    wrong = sampled_deviation(moved) > 1.5 * own.deviation + 1e-7
    return case.with_segments(name, {i: moved}) if wrong else None


def sampled_deviation(segment: Segment) -> float:
    """The greatest distance of a joint from the piece of the path under way, at 50 moments of each."""
    own, path, worst = segment.trajectory, np.array(segment.waypoints), 0.0
    for a, b, start, end in zip(path, path[1:], segment.times, segment.times[1:], strict=False):
        places, way = own.at(np.linspace(start, end, 50)) - a, b - a
        shares = np.clip(places @ way / max(way @ way, 1e-300), 0.0, 1.0)
        worst = max(worst, float(np.abs(places - shares[:, None] * way).max()))
    return worst


@mutation
def a_deviation_told_too_small(case, rng):
    """Smaller than a sampled one."""
    found = a_followed_segment(case, rng, lambda s: s.trajectory.deviation > 1e-6 and sampled_deviation(s) > 1e-6)
    if found is None:
        return None
    name, i, segment = found
    return with_trajectory(case, name, i, deviation=float(rng.uniform(0.0, 0.9)) * sampled_deviation(segment))


@mutation
def a_trajectory_left_out(case, rng):
    """One segment has none, others have."""
    found = a_followed_segment(case, rng)
    if found is None or sum(s.trajectory is not None for _, _, s in case.segments()) < 2:
        return None
    name, i, segment = found
    return case.with_segments(name, {i: replace(segment, trajectory=None)})


@mutation
def velocities_that_jump(case, rng):
    """A segment from way point to way point at constant velocity, as in the old format."""
    found = a_followed_segment(case, rng)
    if found is None:
        return None
    name, i, segment = found
    own = Trajectory.linear(segment.joints, segment.waypoints, segment.times)
    return case.with_segments(name, {i: replace(segment, trajectory=replace(own, deviation=1e-9))})


def _timed(segment: Segment, factor: float, shift: float = 0.0) -> Segment:
    """The segment in `factor` times its time, counted from 0, and later by `shift`."""
    own = segment.trajectory
    pieces = tuple(
        tuple(tuple(c / factor**power for power, c in enumerate(joint)) for joint in piece)
        for piece in own.coefficients
    )
    times = tuple(t * factor + shift for t in own.times)
    moved = replace(own, times=times, coefficients=pieces)
    return replace(segment, times=tuple(t * factor + shift for t in segment.times), trajectory=moved)


@mutation
def a_motion_that_is_too_fast(case, rng):
    """A node in less time: with so much less, its greatest jerk is four times what it was."""
    names = [name for name, node in case.plan.nodes.items() if node.motion and not node.overlap]
    name = pick(rng, [n for n in names if all(s.trajectory is not None for s in case.plan.nodes[n].motion)])
    if name is None:
        return None
    motion = case.plan.nodes[name].motion
    factor = float(rng.uniform(0.2, 0.6))
    used = max(_share_of_jerk(case, segment) for segment in motion)
    if used / factor**3 < 1.01:
        return None
    return case.with_node(name, motion=tuple(_timed(s, factor) for s in motion))


def _share_of_jerk(case: Case, segment: Segment) -> float:
    robot, own = case.scene.robots[segment.robot], segment.trajectory
    index = [robot.joint_names.index(joint) for joint in segment.joints]
    velocity = np.array(robot.tree.velocity)[index]
    acceleration = np.array(
        [robot.acceleration.get(j, v / 0.25) for j, v in zip(own.joints, velocity, strict=True)]
    )
    jerk = np.array([robot.jerk.get(j, a / 0.05) for j, a in zip(own.joints, acceleration, strict=True)])
    return float((np.abs(own.at(np.linspace(own.times[0], own.times[-1], 500)[1:-1], 3)) / jerk).max())


@mutation
def a_pause_in_the_midst_of_a_motion(case, rng):
    """A segment is cut where it is fast, and what is left of the node comes later."""
    found = a_followed_segment(case, rng, _fast_knots)
    if found is None or case.plan.nodes[found[0]].overlap:
        return None
    name, i, segment = found
    motion, own = case.plan.nodes[name].motion, segment.trajectory
    if any(s.trajectory is None for s in motion):
        return None
    if any(s is not segment and s.times[0] < segment.times[-1] and s.times[-1] > segment.times[0] for s in motion):
        return None
    k = pick(rng, _fast_knots(segment))
    cut, late = own.times[k], float(rng.uniform(0.01, 1.0))
    row = tuple(map(float, own.at(cut)))
    halves = []
    for keep, pieces, times in (
        ([t < cut - 1e-9 for t in segment.times], own.coefficients[:k], own.times[: k + 1]),
        ([t > cut + 1e-9 for t in segment.times], own.coefficients[k:], own.times[k:]),
    ):
        rows = [r for r, kept in zip(segment.waypoints, keep, strict=True) if kept]
        when = [t for t, kept in zip(segment.times, keep, strict=True) if kept]
        first = bool(keep[0])
        path = tuple([*rows, row] if first else [row, *rows])
        passed = tuple([*when, cut] if first else [cut, *when])
        part = Trajectory(own.joints, path, times, pieces, own.deviation)
        halves.append(replace(segment, waypoints=path, times=passed, trajectory=part))
    before = replace(halves[0], attach=(), detach=())
    after = [_timed(s, 1.0, late) for s in (halves[1], *motion[i + 1 :])]
    return case.with_node(name, motion=(*motion[:i], before, *after))


@mutation
def a_joint_that_may_not_change_its_acceleration_so_fast(case, rng):
    """The scene's limit of jerk is lower than what a segment needs."""
    found = a_followed_segment(case, rng, lambda s: _share_of_jerk(case, s) > 0.5)
    if found is None:
        return None
    described = case.problem.scene.robots
    robot = found[2].robot
    limit = RateLimits(every=RateLimit(float(rng.uniform(0.001, 0.1))))
    return case.with_scene(robots={**described, robot: replace(described[robot], jerk=limit)})
