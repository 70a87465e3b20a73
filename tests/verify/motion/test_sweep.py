"""Conservative advancement on a slider, where every distance can be worked out by hand."""

import numpy as np
import pytest
import trimesh

from kabo.language.scene_description import PoseDescription, RobotDescription
from kabo.scene import Mesh
from kabo.scene.urdf import load_robot
from kabo.verify.motion.arms import Arm
from kabo.verify.motion.surfaces import surface
from kabo.verify.motion.sweep import Path, SweptBody, open_intervals

SLIDER = """<robot name="slider"><link name="rail"/>
  <link name="block"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <joint name="x" type="prismatic"><parent link="rail"/><child link="block"/><axis xyz="1 0 0"/>
    <limit lower="-5" upper="5" velocity="1" effort="1"/></joint></robot>"""


@pytest.fixture
def prove(tmp_path):
    (tmp_path / "slider.urdf").write_text(SLIDER)
    robot, _ = load_robot(RobotDescription("s", tmp_path / "slider.urdf", PoseDescription()), np.eye(4), {})
    arm = Arm(robot)
    box = trimesh.creation.box

    def run(size, place, xs=(-1.0, 1.0), below=np.inf):
        """The proof for a box of this size, or a mesh, at this place, and how many pairs moved at all."""
        block = SweptBody("s.block", surface(robot.links["block"].mesh), mount=arm.mounts["block"])
        made = box(size) if isinstance(size, tuple) else size
        other = SweptBody(
            "box", surface(Mesh(np.ascontiguousarray(made.vertices), np.asarray(made.faces, np.int64))), np.eye(4)
        )
        other.world_T[:3, 3] = place
        path = Path(arm, np.array(xs)[:, None], np.arange(len(xs), dtype=float))
        moving, left = open_intervals(path, [(block, other)])
        return (left[0][0].advance(left[0][1], below=below) if left else None), moving

    return run


def test_a_plate_thinner_than_any_step_is_hit(prove):
    proof, _ = prove((1e-5, 1, 1), (0.123, 0, 0))
    assert proof.contact is not None and proof.contact.distance is None
    assert 0.51 <= proof.contact.time <= 0.62  # the block is at the plate from x = 0.073 to 0.173


def test_a_long_way_beside_a_near_wall_is_proven_with_steps_of_the_gap(prove):
    for gap in (0.05, 0.005, 0.0005):
        proof, _ = prove((4, 0.1, 1), (0, 0.1 + gap, 0))
        assert proof.contact is None
        assert proof.least == pytest.approx(gap, abs=1e-6)
        assert proof.distances < 5 / gap


def a_c():
    ends = [
        trimesh.creation.box((0.2, 0.3, 1), trimesh.transformations.translation_matrix((x, 0, 0))) for x in (-2, 2)
    ]
    back = trimesh.creation.box((4, 0.1, 1), trimesh.transformations.translation_matrix((0, 0.1, 0)))
    return trimesh.util.concatenate([*ends, back])


def test_the_least_distance_is_that_of_the_bodies_not_of_their_hulls(prove):
    """A short way in front of a C: its hull, 1 cm away, proves that it is free, but its back is 21 cm away."""
    proof, _ = prove(a_c(), (0, 0.21, 0), xs=(-0.01, 0.0))
    assert proof.contact is None
    assert proof.least == pytest.approx(0.21, abs=1e-6)


@pytest.mark.parametrize("below", [0.0, 0.15, 0.25, np.inf])
def test_the_least_distance_is_measured_only_where_it_is_of_interest(prove, below):
    proof, _ = prove(a_c(), (0, 0.21, 0), xs=(-0.01, 0.0), below=below)
    assert proof.contact is None and proof.tells(below)
    if below > 0.21:
        assert proof.least == pytest.approx(0.21, abs=1e-6) and proof.tells(np.inf)
    else:
        assert below <= proof.least <= 0.21 and (below > 0.0 or proof.least < 0.02)  # of the hull
        assert not proof.tells(0.25)


def test_a_gap_too_small_to_decide_is_said_to_be_that(prove):
    proof, _ = prove((4, 0.1, 1), (0, 0.1 + 1.5e-6, 0))
    assert proof.contact is not None and proof.contact.distance == pytest.approx(1.4e-6, abs=2e-7)


def test_touching_along_the_way_is_a_contact(prove):
    proof, _ = prove((4, 0.1, 1), (0, 0.1, 0))
    assert proof.contact is not None and proof.contact.distance is None


def test_what_is_far_needs_no_distance_and_what_stands_no_proof(prove):
    assert prove((0.1, 0.1, 0.1), (0, 3, 0)) == (None, 1)
    assert prove((0.1, 0.1, 0.1), (0, 0.05, 0), xs=(0.5, 0.5)) == (None, 0)


def test_turning_back_between_way_points_is_part_of_the_way(prove):
    assert prove((0.1, 0.1, 0.1), (1.0, 0, 0), xs=(0.0, 0.2, 0.0))[0] is None
    assert prove((0.1, 0.1, 0.1), (1.0, 0, 0), xs=(0.0, 0.95, 0.0))[0].contact is not None
