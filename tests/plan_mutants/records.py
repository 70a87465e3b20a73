"""Mutants of certificates, times and records."""

from dataclasses import replace

import numpy as np

from kabo.plan import ObjectPose, Plan, Segment
from tests.plan_mutants.core import Case, mutation, pick, through


# --------------------------------------------------------------------------------------------------------- certificates
def with_certificate(case: Case, **changes) -> Plan | None:
    """The plan with its certificate changed."""
    certificate = case.plan.certificate
    return None if certificate is None else replace(case.plan, certificate=replace(certificate, **changes))


@mutation
def another_epsilon_in_the_certificate(case, rng):
    """Not that of the plan."""
    assert case.plan.certificate is not None
    factor = float(rng.choice([0.1, 0.5, 0.999, 1.001, 2.0, 10.0]))
    return with_certificate(case, epsilon=case.plan.certificate.epsilon * factor)


@mutation
def a_clearance_told_too_large(case, rng):
    """Larger than everything that is looked at."""
    entries = list(case.plan.certificate.segments)
    k = int(rng.integers(len(entries)))
    entries[k] = replace(entries[k], clearance=case.plan.certificate.near * float(rng.uniform(1.01, 3.0)))
    return with_certificate(case, segments=tuple(entries))


@mutation
def a_stretch_without_proof(case, rng):
    """One is left out."""
    proofs = list(case.plan.certificate.proofs)
    proofs.pop(int(rng.integers(len(proofs))))
    return with_certificate(case, proofs=tuple(proofs))


@mutation
def a_stretch_proven_twice(case, rng):
    """One comes twice."""
    proofs = case.plan.certificate.proofs
    return with_certificate(case, proofs=(*proofs, pick(rng, proofs)))


@mutation
def parts_that_do_not_enclose(case, rng):
    """The parts of one body shrunk about their middle."""
    bodies = dict(case.plan.certificate.bodies)
    moved = [f"sha256:{case.scene.bodies[name].mesh.digest}" for name in case.scene.movable]
    digest = pick(rng, sorted({d for d in moved if d in bodies}))
    vertices = np.frombuffer(bodies[digest].vertices).reshape(-1, 3)
    middle = vertices.mean(axis=0)
    smaller = middle + rng.uniform(0.5, 0.97) * (vertices - middle)
    bodies[digest] = replace(bodies[digest], vertices=smaller.tobytes())
    return with_certificate(case, bodies=bodies)


@mutation
def contacts_told_otherwise(case, rng):
    """The certificate tells of a contact that the segment does not permit."""
    entries = list(case.plan.certificate.segments)
    k = int(rng.integers(len(entries)))
    entries[k] = replace(entries[k], permitted=(*entries[k].permitted, ("x", "y")))
    return with_certificate(case, segments=tuple(entries))


# ------------------------------------------------------------------------------------------- way points, times, records
def a_moving_arm(case: Case, rng: np.random.Generator) -> tuple[str, int, Segment]:
    """A segment of an arm that goes somewhere."""
    found = [(n, i, s) for n, i, s in case.segments() if len(s.joints) > 2 and s.waypoints[0] != s.waypoints[-1]]
    return pick(rng, found)


@mutation
def a_jump(case, rng):
    """A segment begins elsewhere than the arm is."""
    name, i, segment = a_moving_arm(case, rng)
    row = np.array(segment.waypoints[0]) + rng.normal(0.0, 0.01, len(segment.joints)) + 1e-4
    return case.with_segments(name, {i: replace(segment, waypoints=(tuple(row), *segment.waypoints[1:]))})


@mutation
def a_joint_beyond_its_limit(case, rng):
    """A way point between that no joint may take."""
    name, i, segment = a_moving_arm(case, rng)
    robot = case.scene.robots[segment.robot]
    j = int(rng.integers(len(segment.joints)))
    row = np.array(segment.waypoints[0])
    row[j] = robot.tree.upper[robot.joint_names.index(segment.joints[j])] + rng.uniform(1e-4, 0.5)
    return through(case, name, {i: [segment.waypoints[0], tuple(map(float, row)), *segment.waypoints[1:]]})


@mutation
def too_fast(case, rng):
    """In a hundredth of the time or less: plans move at half of the limits and slower."""
    name, i, segment = a_moving_arm(case, rng)
    factor = float(rng.uniform(0.001, 0.01))
    times = tuple(round(segment.times[0] + factor * (t - segment.times[0]), 9) for t in segment.times)
    return case.with_segments(name, {i: replace(segment, times=times)})


@mutation
def time_that_stands_still(case, rng):
    """Two way points at one time."""
    name, i, segment = a_moving_arm(case, rng)
    k = int(rng.integers(1, len(segment.times)))
    times = (*segment.times[:k], segment.times[k - 1], *segment.times[k + 1 :])
    return case.with_segments(name, {i: replace(segment, times=times)})


@mutation
def two_segments_at_once(case, rng):
    """A segment of an arm begins before its last one has ended."""
    found = [
        (n, i)
        for n, i, s in case.segments()
        if i > 0 and case.plan.nodes[n].motion[i - 1].robot == s.robot and s.times[0] > 0.1
    ]
    chosen = pick(rng, found)
    if chosen is None:
        return None
    name, i = chosen
    segment = case.plan.nodes[name].motion[i]
    before = case.plan.nodes[name].motion[i - 1]
    early = rng.uniform(0.1, 0.9) * (before.times[-1] - before.times[0])
    return case.with_segments(name, {i: replace(segment, times=tuple(round(t - early, 6) for t in segment.times))})


@mutation
def a_robot_recorded_elsewhere(case, rng):
    """`after` says that a joint is elsewhere than the motion leaves it."""
    found = pick(rng, [n for n, node in case.plan.nodes.items() if node.after is not None and node.after.robots])
    node = case.plan.nodes[found]
    robot = pick(rng, sorted(node.after.robots))
    joint = pick(rng, sorted(node.after.robots[robot]))
    joints = {**node.after.robots[robot], joint: node.after.robots[robot][joint] + float(rng.uniform(1e-5, 0.1))}
    return case.with_node(found, after=replace(node.after, robots={**node.after.robots, robot: joints}))


@mutation
def an_object_recorded_elsewhere(case, rng):
    """`after` says that an object is elsewhere than the motion leaves it."""
    found = pick(rng, [n for n, node in case.plan.nodes.items() if node.after is not None and node.after.objects])
    node = case.plan.nodes[found]
    name = pick(rng, sorted(node.after.objects))
    pose = node.after.objects[name]
    shift = rng.normal(size=3)
    shift *= rng.uniform(1e-5, 0.05) / np.linalg.norm(shift)
    moved = replace(pose, position=tuple(float(a + b) for a, b in zip(pose.position, shift, strict=True)))
    return case.with_node(found, after=replace(node.after, objects={**node.after.objects, name: moved}))


@mutation
def another_start(case, rng):
    """An object begins elsewhere than the scene puts it."""
    start = case.plan.start
    name = pick(rng, sorted(start.objects))
    pose: ObjectPose = start.objects[name]
    x, y, z = pose.position
    moved = replace(pose, position=(x + float(rng.uniform(1e-5, 0.1)), y, z))
    return replace(case.plan, start=replace(start, objects={**start.objects, name: moved}))
