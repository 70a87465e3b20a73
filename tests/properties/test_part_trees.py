"""Bodies whose parts are refined on demand, against coal on their meshes: both sides of [K Def. 1.1, 1.2]."""

from functools import cache

import numpy as np
import trimesh
from hypothesis import event, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kabo.geometry import Budget, CollisionView, Enclosure, FixedGroup, MovingGroup, collides, enclosing_parts
from kabo.geometry.collision.part_trees import known
from kabo.meshes import Mesh
from tests.geometry.worlds import move, slide
from tests.support.oracles_coal import distance

BUDGET = Budget.share(0.01)
COARSE = 0.03  # of the roots [m]; children are within 4 mm
FAR = 0.5  # [m] where the rings are apart whatever the rotation
SAMPLES = 40  # of a stretch


@cache
def ring() -> tuple[Mesh, Enclosure]:
    """A ring of 10 cm with a hole of 6 cm, and its parts as a tree."""
    made = trimesh.creation.annulus(0.03, 0.05, 0.02, sections=24)
    mesh = Mesh(np.array(made.vertices, np.float64), np.array(made.faces, np.int64))
    return mesh, enclosing_parts(mesh, BUDGET.geometry, coarse=COARSE)


@st.composite
def poses(draw):
    """world_T_second (4, 4) beside the first ring, a direction (3,), and a stretch along it [m]."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    gap = BUDGET.epsilon * draw(st.sampled_from([-0.5, 0.0, 0.3, 0.7, 0.98, 1.001, 1.2, 2.0]))
    away = rng.normal(size=3)
    away /= np.linalg.norm(away)
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(random_state=rng).as_matrix()
    aim, mesh = rng.normal(size=3) * 0.02, ring()[0]
    place = FAR
    for _ in range(300):  # comes nearer by as much as coal says that there is room
        pose[:3, 3] = aim + place * away
        room = distance(mesh, np.eye(4), mesh, pose) - max(gap, 0.0)
        if room < 1e-7 or place < -FAR:
            break
        place -= room
    pose[:3, 3] = aim + (place + min(gap, 0.0)) * away
    return pose, away, draw(st.sampled_from([0.0, 0.002, 0.02]))


@given(case=poses())
def test_refined_bodies_are_judged_as_coal_judges_their_meshes(case):
    pose, away, length = case
    mesh, enclosure = ring()
    assert enclosure.finer is not None
    steps = [pose] + [pose.copy() for _ in range(SAMPLES)]
    for number, step in enumerate(steps):
        step[:3, 3] += away * length * number / SAMPLES
    found = [distance(mesh, np.eye(4), mesh, step) for step in steps]
    event("here: " + ("contact" if found[0] <= 0 else "free" if found[0] >= BUDGET.epsilon else "between"))

    here = np.concatenate([pose[:3, :3].ravel(), pose[:3, 3]])
    first = FixedGroup(move(0, 0, 0), enclosure)
    hit = collides(first, FixedGroup(here, enclosure), BUDGET)
    assert hit or found[0] > 0.0, "overlooked a collision"
    assert not hit or found[0] < BUDGET.epsilon, f"refused a free pair: coal {found[0]:.3e} m"

    rail, _ = Rotation.align_vectors([away], [[0.0, 0.0, 1.0]])
    turn = rail.as_matrix()
    placement = np.concatenate([turn.ravel(), pose[:3, 3]])
    own = np.concatenate([(turn.T @ pose[:3, :3]).ravel(), np.zeros(3)])
    pairs = np.array([[0, 1]])
    view = CollisionView(slide(placement), [MovingGroup(1, own, enclosure)], [first], pairs, BUDGET)
    swept = view.segment_hit(np.zeros(1), np.full(1, length)) >= 0
    assert swept or min(found) > 0.0, "overlooked a collision on the way"
    assert not swept or min(found) - length / SAMPLES < BUDGET.epsilon, "refused a free way"


def test_a_ring_within_the_hole_of_what_encloses_another_is_free_once_it_is_refined():
    """Roots of 3 cm fill the hole; a small ring in it is 1.5 cm away from all of the large one."""
    mesh, enclosure = ring()
    small = Mesh(mesh.vertices * 0.3, mesh.faces)
    inner = enclosing_parts(small, BUDGET.geometry)
    assert distance(mesh, np.eye(4), small, np.eye(4)) > 0.01
    here = move(0, 0, 0)
    roots = Enclosure(tuple(enclosure.parts[i] for i in enclosure.root_parts), enclosure.deviation_of_roots)
    assert collides(FixedGroup(here, roots), FixedGroup(here, inner), Budget(COARSE, 0.001, 0.001))
    assert not collides(FixedGroup(here, enclosure), FixedGroup(here, inner), BUDGET)
    assert len(known(enclosure).parts) > len(enclosure.parts)
