"""What is called a stroke is one at every place of it: the proof against a dense sampling of the arm's path."""

import os
from functools import cache
from pathlib import Path

import numpy as np
from hypothesis import event, given, settings
from hypothesis import strategies as st

from kabo.language import load_problem
from kabo.scene import link_pose, load_scene
from kabo.verify.motion.arms import Arm, Mount
from kabo.verify.motion.contacts.strokes import (
    MAX_CORNER_SLOPE,
    MAX_CORNER_TURN,
    MAX_OFFSET,
    MAX_OFFSET_SLOPE,
    MAX_TURN,
    Stroke,
    box_corners,
    of_family,
    of_mate,
)
from kabo.verify.motion.sweep import Path as Motion

DOMAINS = Path(__file__).parents[4] / "domains"
EXAMPLES = settings(max_examples=max(40, round(400 * float(os.environ.get("KABO_PROPERTY_SCALE", "0.1")))))
PLACES = 60  # of each piece, for the oracle


@cache
def robot():
    return load_scene(load_problem(DOMAINS / "bartender" / "four_bottles.yaml").scene).robots["left"]


def sampled(rows):
    """The tool's poses (N, 4, 4) all along a path, by the scene's own kinematics."""
    dense = [a + s * (b - a) for a, b in zip(rows, rows[1:], strict=False) for s in np.linspace(0, 1, PLACES)]
    return np.array([link_pose(robot(), tuple(q), "tool0") for q in dense])


def following(q, way, rng, pieces):
    """Rows (pieces + 1, n) whose tool goes along a vector, each a step of Newton from the last, and noise."""
    rows, step = [q], way / pieces
    for _ in range(pieces):
        start = link_pose(robot(), tuple(rows[-1]), "tool0")
        q = rows[-1].copy()
        for _ in range(4):
            pose = link_pose(robot(), tuple(q), "tool0")
            error = [*(start[:3, 3] + step - pose[:3, 3]), *_turned(pose, start)]
            jacobian = []
            for j in range(6):
                moved = q.copy()
                moved[j] += 1e-6
                other = link_pose(robot(), tuple(moved), "tool0")
                jacobian.append([*((other - pose)[:3, 3] / 1e-6), *(-np.array(_turned(other, pose)) / 1e-6)])
            q[:6] += np.linalg.lstsq(np.array(jacobian).T, error, rcond=1e-3)[0]
        rows.append(q)
    return np.array(rows)


def _turned(pose, start):
    """The vector (3,) by which a pose has to turn to be as at the start, for small angles."""
    turn = start[:3, :3] @ pose[:3, :3].T
    return [(turn[2, 1] - turn[1, 2]) / 2, (turn[0, 2] - turn[2, 0]) / 2, (turn[1, 0] - turn[0, 1]) / 2]


@EXAMPLES
@given(
    seed=st.integers(0, 10**6),
    pieces=st.integers(1, 4),
    noise=st.sampled_from([0.0, 0.0, 1e-5, 1e-3, 1e-2]),
    mate=st.booleans(),
    backward=st.booleans(),
)
def test_a_proven_stroke_keeps_its_limits_at_every_place(seed, pieces, noise, mate, backward):
    rng = np.random.default_rng(seed)
    q = np.append(np.array([0.0, -0.35, 1.9, 0.0, 1.57, 0.0]) + rng.uniform(-0.3, 0.3, 6), 0.03)
    way = rng.normal(size=3)
    way *= rng.uniform(0.03, 0.12) / np.linalg.norm(way)
    rows = following(q, way, rng, pieces)
    rows[1:, :6] += noise * rng.normal(size=(pieces, 6))
    arm = Arm(robot())
    mount = Mount(arm.mounts["tool0"].joint, np.eye(4), "left")
    corners = box_corners(np.array([-0.03, -0.03, 0.0]), np.array([0.03, 0.03, 0.2]))
    away = way / np.linalg.norm(way)
    limits = of_mate(0.03, 0.12, 4e-4) if mate else of_family(0.03, 0.12)
    ordered = rows[::-1] if backward else rows
    stroke = Stroke(
        Motion(arm, ordered, np.arange(len(rows))), mount, corners, away, limits, backward, 8 if mate else 1
    )
    fault = stroke.fault()
    event("a stroke" if fault is None else "none")
    poses = sampled(rows) @ _joint_in_tool(arm)
    places = np.einsum("nrc,pc->npr", poses[:, :3, :3], corners) + poses[:, None, :3, 3]
    moved = places - places[0]
    along = moved @ away
    aside = np.linalg.norm(moved - along[..., None] * away, axis=2)
    turned = [np.linalg.norm(poses[0, :3, :3].T @ p[:3, :3] - np.eye(3)) / np.sqrt(2) for p in poses]
    near = along[:, 0] < limits.near
    if fault is not None:
        return
    assert limits.least <= along[-1, 0] <= limits.most
    checked = 8 if mate else 1
    grown = np.diff(along, axis=0)[near[:-1] & near[1:]]
    assert (grown > -1e-12).all(), "comes back"
    slope = np.where(near, 0.0 if mate else MAX_OFFSET_SLOPE, MAX_CORNER_SLOPE)
    bound = (4e-4 if mate else MAX_OFFSET) + slope * np.maximum(0.0, along[:, 0])
    assert (aside[:, :checked].max(axis=1) <= bound + 1e-9).all(), "leaves its line"
    assert (np.array(turned) <= np.where(near, MAX_TURN, MAX_CORNER_TURN) + 1e-9).all(), "turns"


def _joint_in_tool(arm):
    return np.linalg.inv(arm.mounts["tool0"].joint_T_body)
