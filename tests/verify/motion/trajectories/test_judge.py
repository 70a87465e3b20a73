"""Segments with trajectories: what is told of each fault, and that a right one has none."""

from dataclasses import replace

import pytest

from kabo.motion import Trajectory
from kabo.plan import Segment
from kabo.scene import Robot, load_scene
from kabo.verify import verify_plan
from kabo.verify.motion.arms import Arm
from kabo.verify.motion.trajectories.figures import TrajectoryFigures
from kabo.verify.motion.trajectories.judge import SegmentJudge, check_form, followed
from tests.verify import bench
from tests.verify.smooth import quintics, smooth

PATH = ((0.0, 0.0, -0.2, 0.0), (0.2, -0.1, -0.1, 0.4))


@pytest.fixture(scope="module")
def robot(tmp_path_factory) -> Robot:
    """A gantry: x, y and z slide at 1 m/s, tilt turns at 2 rad/s."""
    problem = bench.load(tmp_path_factory.mktemp("bench")).problem
    assert problem.scene is not None
    return load_scene(problem.scene).robots["left"]


def moved(times: tuple[float, ...] = (0.0, 0.8)) -> Segment:
    """The segment from one end of PATH to the other."""
    segment = Segment("left", ("x", "y", "z", "tilt"), PATH, times, "move")
    return replace(segment, trajectory=quintics(segment, times))


def findings(segment: Segment, robot: Robot) -> list[str]:
    wrong = [f.message for f in check_form("n0", 3, segment)]
    if wrong:
        return wrong
    judge = SegmentJudge("n0", 3, segment, Arm(robot), TrajectoryFigures())
    return [f.message for f in judge.check(followed(segment))]


def spoilt(piece: int = 0, joint: int = 0, power: int = 0, by: float = 0.0, **changes) -> Segment:
    segment = moved()
    rows = [list(each) for each in segment.trajectory.coefficients]
    powers = [*rows[piece][joint], *[0.0] * 6][:6]
    powers[power] += by
    rows[piece][joint] = tuple(powers)
    own = replace(segment.trajectory, **({"coefficients": tuple(map(tuple, rows))} | changes))
    return replace(segment, trajectory=own)


def test_a_right_trajectory_has_no_finding(robot):
    assert findings(moved(), robot) == []


@pytest.mark.parametrize(
    ("segment", "told"),
    [
        (moved((0.0, 0.2)), "segment 3: left.x reaches an acceleration of 28.8674 m/s², its limit is 4 m/s²"),
        (moved((0.0, 0.2)), "segment 3: left.x reaches a velocity of 1.875 m/s, its limit is 1 m/s"),
        (moved((0.0, 0.5)), "segment 3: left.x reaches a jerk of 96 m/s³, its limit is 80 m/s³"),
        (spoilt(by=1e-6), "segment 3: the trajectory of left.x ends 1e-06 m from its path"),
        (
            spoilt(joint=3, power=2, by=0.01),
            "segment 3: the trajectory of left.tilt ends 0.0064 rad from its path",
        ),
        (spoilt(joint=1, power=1, by=0.01), "leaves its path by up to"),
        (spoilt(power=5, by=float("nan")), "has no 1 to 6 finite coefficients"),
        (spoilt(power=5, by=1e300), "piece 0 of its trajectory leads farther than 1e+06 rad or m"),
        (spoilt(by=-1e300), "piece 0 of its trajectory leads farther than 1e+06 rad or m"),
        (spoilt(times=(0.0, 0.4)), "segment 3: its trajectory lasts from 0 to 0.4 s, it lasts from 0 to 0.8 s"),
        (spoilt(times=(0.0, 0.4, 0.8)), "segment 3: its trajectory has 1 pieces and 3 times"),
        (spoilt(deviation=-1.0), "states a deviation of -1.0"),
        (spoilt(waypoints=PATH[::-1]), "is for other joints or another path"),
        (spoilt(coefficients=(((0.0,),),)), "piece 0 of its trajectory has 1 polynomials for 4 joints"),
    ],
)
def test_each_fault_is_told_with_joint_value_and_limit(segment, told, robot):
    assert any(told in text for text in findings(segment, robot)), findings(segment, robot)


def test_a_position_between_way_points_beyond_its_limit_is_found(robot):
    """The joint swings 0.7 m far between two way points inside its limits of 0.6 m."""
    path = ((0.0, 0.0, -0.2, 0.0), (0.0, 0.0, -0.2, 0.0))
    segment = Segment("left", ("x", "y", "z", "tilt"), path, (0.0, 10.0), "move")
    swing = tuple(0.7 * 16 * c for c in (0.0, 0.0, 1e-2, -2e-3, 1e-4))  # 0 at both ends, with velocity 0
    own = Trajectory(segment.joints, path, (0.0, 10.0), ((swing, (0.0,), (-0.2,), (0.0,)),), 0.7)
    texts = findings(replace(segment, trajectory=own), robot)
    assert "segment 3: left.x reaches 0.7 m, its limits are -0.6 and 0.6 m" in [t[:66] for t in texts], texts


def test_a_stated_deviation_is_enough_up_to_the_one_found(robot):
    """Blended by hand: the corner is passed at a distance, on its inner side."""
    path = ((0.0, 0.0, -0.2, 0.0), (0.1, 0.0, -0.2, 0.0), (0.1, 0.1, -0.2, 0.0))
    t = 4.0
    there = (0.0, 0.0, 0.0, 10 * 0.1 / t**3, -15 * 0.1 / t**4, 6 * 0.1 / t**5)
    whole = Trajectory(("x", "y", "z", "tilt"), path, (0.0, t), ((there, there, (-0.2,), (0.0,)),), 0.0)
    segment = Segment("left", whole.joints, path, (0.0, t / 2, t), "move", trajectory=whole)
    (text,) = findings(segment, robot)
    assert "segment 3: the trajectory of left.y leaves its path by up to 0.05" in text or "left.x leaves" in text
    enough = replace(segment, trajectory=replace(whole, deviation=0.0501))
    assert findings(enough, robot) == []
    assert len(findings(replace(segment, trajectory=replace(whole, deviation=0.0499)), robot)) == 1


def test_jumps_between_pieces_are_told(robot):
    segment = moved()
    own = segment.trajectory
    later = tuple((float(value),) for value in own.at(0.4))
    cut = replace(own, times=(0.0, 0.4, 0.8), coefficients=(*own.coefficients, later))
    texts = findings(replace(segment, trajectory=cut), robot)
    assert any("the velocity of left.tilt jumps by 0.938 rad/s between two pieces" in text for text in texts), (
        texts
    )


def test_a_plan_with_trajectories_is_verified_and_the_report_tells_their_figures(tmp_path):
    world = bench.load(tmp_path)
    plan = world.plan(bench.take_peg(), bench.hand_over())
    report = verify_plan(world.problem, smooth(plan, load_scene(world.problem.scene)))
    assert report.ok, str(report)
    assert report.trajectories is not None and report.trajectories.segments == sum(
        len(node.motion) for node in plan.nodes.values()
    )
    shares = {use.kind: use.share for use in report.trajectories.uses}
    assert shares.keys() == {"velocity", "acceleration", "jerk"} and 0.9 < max(shares.values()) <= 1.0
    assert "limits used at most: velocity" in str(report) and "follow the proven paths exactly" in str(report)
    assert report.to_dict()["trajectories"]["limits_used"]["jerk"]["limit"] > 0
    old = verify_plan(world.problem, plan)
    assert old.ok and old.trajectories is None and "kabo-plan/1" in old.notes[0]
