"""Certificates of random boxes on a robot: what is made is accepted, and nothing is accepted that collides.

The oracle is coal's distance between the meshes at many places of the path; proofs, walks, axes and parts are made by
the planner's side and judged by the verifier's.
"""

import os
from dataclasses import replace

import numpy as np
from hypothesis import event, given, settings
from hypothesis import strategies as st

from kabo.geometry.collision.separation_proofs import SHARE_OF_CLEARANCE, Unproven
from kabo.planner.certify.motion_situation import joint_pose
from kabo.verify.certificate.pair_proof import Refuted
from kabo.verify.motion.surfaces import encloses, mesh_distance
from tests.verify.certified import BUDGET, OUT, Box, Scenery, box, small_robot, sought

SCALE = float(os.environ.get("KABO_PROPERTY_SCALE", "1"))
EXAMPLES = settings(max_examples=max(10, round(150 * SCALE)), deadline=None)
LOOKS = 60  # places of the path at which the oracle looks


def turned(rng: np.random.Generator) -> np.ndarray:
    """A random rotation (3, 3)."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def pose(rng: np.random.Generator, far: float) -> np.ndarray:
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = turned(rng), rng.uniform(-far, far, 3)
    return result


def scenery(seed: int) -> Scenery:
    """Two boxes: one on a joint, the other in the world or on another joint; a path of one to four pieces."""
    rng, (robot, _) = np.random.default_rng(seed), small_robot()
    joints = sorted({link.joint for link in robot.links.values() if link.joint > 0})
    count, stride = int(rng.integers(2, 6)), float(rng.choice([0.02, 0.3, 1.5]))
    lower, upper = np.maximum(robot.tree.lower, -3.0), np.minimum(robot.tree.upper, 3.0)
    start = rng.uniform(lower, upper)
    steps = rng.normal(size=(count, len(start))) * stride
    waypoints = np.round(np.clip(start + np.cumsum(steps, axis=0), lower, upper), 9)
    first = box(rng.uniform(0.01, 0.3, 3), int(rng.choice(joints)), pose(rng, 0.2))
    others = [0, *(joint for joint in joints if joint != first.joint)]
    joint, size = int(rng.choice(others)) if rng.random() < 0.5 else 0, rng.uniform(0.005, 0.4, 3)
    # The second stands beside where the first is at some place of the path: they meet, or just do not.
    q = waypoints[0] + rng.random() * (waypoints[1] - waypoints[0])
    beside = joint_pose(robot, q, first.joint) @ first.joint_T
    away = rng.normal(size=3)
    reach = np.linalg.norm(size) + np.linalg.norm(np.ptp(first.mesh.vertices, axis=0))
    beside[:3, 3] += away / np.linalg.norm(away) * rng.uniform(0.1, 0.6) * reach
    beside[:3, :3] = turned(rng)
    return sought(first, box(size, joint, np.linalg.inv(joint_pose(robot, q, joint)) @ beside), waypoints)


def distances(scene: Scenery) -> np.ndarray:
    """What coal measures at many places; less than 0 where one box lies in the other."""
    path, (first, second) = scene.path(), scene.things()
    found = []
    for piece in range(len(scene.waypoints) - 1):
        for share in np.linspace(0.0, 1.0, LOOKS // (len(scene.waypoints) - 1)):
            at = path.poses(piece, float(share))
            a, b = first.pose(at), second.pose(at)
            inside = encloses(first.surface, a, second.surface, b) or encloses(second.surface, b, first.surface, a)
            found.append(-1.0 if inside else mesh_distance(first.surface, a, second.surface, b))
    return np.array(found)


@EXAMPLES
@given(seed=st.integers(0, 2**32 - 1))
def test_every_proof_is_accepted_with_its_margin_and_no_proof_is_missed(seed):
    scene = scenery(seed)
    near = 0.01
    if isinstance(scene.found, Unproven):
        event("not proven")
        assert distances(scene).min() < BUDGET.clearance + 4 * OUT, "what keeps its clearance has a proof"
        return
    couple = scene.couple()
    if scene.found is None:
        event("no proof needed")
        assert not couple.moves or couple.apart() >= SHARE_OF_CLEARANCE * BUDGET.clearance - 1e-9
        least = np.inf if not couple.moves else min(near, couple.apart())
    else:
        event(
            "proven: "
            + ("axis" if scene.found.walk == "a" else "several" if len(scene.found.walk) < 9 else "many")
        )
        least = couple.check(scene.proof, near).least
        assert least >= min(near, scene.found.margin) - 1e-9, "the verifier finds the same margin"
    if np.isfinite(least):
        assert distances(scene).min() >= least - 1e-6


@EXAMPLES
@given(
    seed=st.integers(0, 2**32 - 1),
    choice=st.integers(0, 5),
    number=st.integers(0, 2**31),
    other=st.integers(-9, 9),
)
def test_what_was_tampered_with_is_refused_or_still_a_proof(seed, choice, number, other):
    scene = next(s for s in map(scenery, range(seed, seed + 1000)) if not isinstance(s.found, Unproven | None))
    changed = tampered(scene, choice, number, other)
    walk, axes = changed.found.walk, changed.found.axes
    if len(axes) != 6 * walk.count("a") + 24 * walk.count("e"):
        event("refused by the reader")
        return
    try:
        least = changed.couple().check(changed.proof, 0.01).least
    except (Refuted, IndexError):
        event("refused")
        return
    event("still a proof")
    found = distances(changed).min()
    assert found > 0.0, f"accepted, but the oracle finds {found}"
    assert found >= least - 1e-6


def tampered(scene: Scenery, choice: int, number: int, other: int) -> Scenery:
    """The scene with its walk, an axis, the path or a box changed, but the proof of before."""
    found = scene.found
    letters, content = list(found.walk), bytearray(found.axes)
    if choice == 0:
        letters[number % len(letters)] = "baetfs"[other % 6]
    elif choice == 1 and content:
        content[number % len(content)] ^= 1 + other % 255
    elif choice == 2:
        del letters[number % len(letters)]
    changed = replace(scene, found=replace(found, walk="".join(letters) or "b", axes=bytes(content)))
    if choice == 3:
        waypoints = scene.waypoints.copy()
        waypoints[number % len(waypoints)] += 0.05 * other
        return replace(changed, waypoints=waypoints)
    if choice == 4:
        moved = scene.second.joint_T.copy()
        moved[number % 3, 3] += 0.02 * other
        return replace(changed, second=Box(scene.second.mesh, scene.second.joint, moved))
    if choice == 5:
        larger = box(np.ptp(scene.first.mesh.vertices, axis=0) * (1 + 0.1 * abs(other)), 0, np.eye(4)).mesh
        return replace(changed, first=Box(larger, scene.first.joint, scene.first.joint_T))
    return changed


@EXAMPLES
@given(seed=st.integers(0, 2**32 - 1))
def test_a_body_may_be_displaced_by_less_than_the_margin(seed):
    scene = scenery(seed)
    if isinstance(scene.found, Unproven | None):
        return
    least = scene.couple().check(scene.proof, 0.01).least
    rng = np.random.default_rng(seed)
    direction = rng.normal(size=3)
    moved = scene.second.joint_T.copy()
    moved[:3, 3] += 0.999 * least * direction / np.linalg.norm(direction)
    displaced = replace(scene, second=Box(scene.second.mesh, scene.second.joint, moved))
    if scene.second.joint == 0:  # on a joint its path is another, too: then only what it may meet is asked
        displaced.couple().check(scene.proof, 0.01)
    assert distances(displaced).min() > 0.0


@EXAMPLES
@given(seed=st.integers(0, 2**32 - 1), size=st.sampled_from([1e-4, 3e-3, 3e-2]))
def test_a_proof_with_a_deviation_holds_wherever_joints_are_within_it(seed, size):
    """Places off the path by corners of the deviation, and inside: coal measures at least the margin of the proof."""
    plain = scenery(seed)
    rng, pieces = np.random.default_rng(seed), len(plain.waypoints) - 1
    off = rng.choice([0.0, 0.3, 1.0], (pieces, plain.waypoints.shape[1])) * size
    scene = sought(plain.first, plain.second, plain.waypoints, deviations=off)
    if isinstance(scene.found, Unproven):
        event("not proven" if isinstance(plain.found, Unproven) else "not proven with it, but without")
        return
    assert not isinstance(plain.found, Unproven)
    if scene.found is None:
        event("no proof needed")
        return
    event("proven")
    for _ in range(3):
        for piece in range(pieces):
            strays = off[piece] * rng.choice([-1.0, -0.5, 1.0], plain.waypoints.shape[1])
            moved = replace(plain, waypoints=plain.waypoints[piece : piece + 2] + strays)
            assert distances(moved).min() >= min(0.01, scene.found.margin) - 1e-6


@EXAMPLES
@given(seed=st.integers(0, 2**32 - 1))
def test_a_wanted_margin_is_reached_within_a_fifth_of_what_there_is(seed):
    """Against coal at many places of the path: the proof tells the least distance, up to `near`."""
    plain = scenery(seed)
    scene = sought(plain.first, plain.second, plain.waypoints, wanted=0.01)
    assert isinstance(scene.found, Unproven) == isinstance(plain.found, Unproven)
    if isinstance(scene.found, Unproven) or scene.found is None:
        return
    least = min(0.01, distances(scene).min())
    assert scene.couple().check(scene.proof, 0.01).least >= min(0.01, scene.found.margin) - 1e-9
    assert min(0.01, scene.found.margin) >= 0.8 * least - 1e-6, (scene.found.margin, least)
    before = 0.0 if plain.found is None else plain.found.margin  # None: boxes left what was wanted
    event("better by far" if scene.found.margin > 2.0 * before else "about the same")
