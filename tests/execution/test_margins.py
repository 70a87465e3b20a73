"""Margins by body, node and direction in runs: what a proof tolerates goes on, with the reason; what it does not, stops."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.arrays import Array
from kabo.errors import InputError
from kabo.execution import (
    Displacement,
    ExecutionSettings,
    KinematicRobot,
    KnownTruth,
    Margins,
    PoseNoise,
    RobotState,
    Run,
    body_margins,
    execute,
)
from kabo.execution.belief import Belief
from kabo.execution.displacements import displacement
from kabo.execution.looks import MOST_LOOKS, Looks, rotation
from kabo.execution.margin_table import table_of
from kabo.execution.margins import FEW_CLAIMS, essential
from kabo.execution.simulated_sensors import normals
from kabo.execution.watching import Watch
from kabo.plan import Plan, ProvenGap
from kabo.scene import Scene
from kabo.streams import stream_key, uniforms
from kabo.verify import Report

DOMAINS = Path(__file__).parents[2] / "domains"
X = np.array([1.0, 0.0, 0.0])
CUBE = 0.03 / np.sqrt(3.0) * np.array(list(product((-1.0, 1.0), repeat=3)))  # corners, 3 cm from its middle
HAND, ARM = ("mobile", 5), ("mobile", 3)


@pytest.fixture(scope="module")
def report(stacked_plan: Plan) -> Report:
    found = kabo.verify(kabo.load_problem(DOMAINS / "stacked" / "n2.yaml"), stacked_plan)
    assert found.ok and found.certificate is not None
    return found


def with_gaps(report: Report, *gaps: ProvenGap) -> Report:
    """The report, as if these were the gaps that the certificate proves."""
    assert report.certificate is not None
    return replace(report, certificate=replace(report.certificate, gaps=gaps))


def beside(plan: Plan, body: str, gap: float, node: str | None = None, **more: object) -> ProvenGap:
    """A link of the arm passes by a body that stands: the link is ahead along x."""
    where = plan.root if node is None else node
    segments = tuple(range(len(plan.nodes[where].motion)))
    made = ProvenGap(where, segments, (), ("mobile.gripper_base", body), (ARM, None), True, gap, ((X, gap),))
    return replace(made, **more)  # type: ignore[arg-type]


class Moved(KnownTruth):
    """Sees bodies elsewhere from the beginning on."""

    def __init__(self, robot: KinematicRobot, offsets: Mapping[str, tuple[float, float, float]]) -> None:
        super().__init__(poses=robot.poses)
        self.offsets = offsets

    def poses(self) -> Mapping[str, Array]:
        found = {name: pose.copy() for name, pose in super().poses().items()}
        for name, offset in self.offsets.items():
            found[name][:3, 3] += offset
        return found


def run_with(
    plan: Plan, scene: Scene, report: Report, offsets: Mapping[str, tuple[float, float, float]], **settings: object
) -> Run:
    robot = KinematicRobot(scene, rate=100.0)
    chosen = ExecutionSettings(**settings)  # type: ignore[arg-type]
    return execute(plan, scene, robot, Moved(robot, offsets), chosen, report=report)


@pytest.mark.parametrize(
    ("offset", "goes_on"),
    [
        ((0.0019, 0, 0), True),
        ((0.0021, 0, 0), False),
        ((-0.0079, 0, 0), True),
        ((0.0015, 0.0075, 0), True),
        ((0, 0, 0.0199), True),
        ((0, 0, 0.0201), False),
    ],
)
def test_a_body_may_be_off_as_far_as_is_proven_in_this_direction(
    offset: tuple[float, float, float], goes_on: bool, stacked_plan: Plan, stacked_scene: Scene, report: Report
) -> None:
    run = run_with(
        stacked_plan, stacked_scene, with_gaps(report, beside(stacked_plan, "o1", 0.002)), {"o1": offset}
    )
    assert run.reached_goal is goes_on, run.reason
    if goes_on:
        told = next(iter(run.log.of("tolerated")))
        assert told["body"] == "o1" and told["off"] == pytest.approx(np.linalg.norm(offset), abs=1e-6)
        assert told["off"] < told["permitted"] and "are proven to be free" in told["reason"]
    else:
        assert (
            run.surprise is not None and run.surprise.thing == "o1" and run.surprise.off > run.surprise.permitted
        )
        what = f"of mobile.gripper_base at {stacked_plan.root}"  # beyond 1 cm it may be anything
        assert ("proven to be free" in run.reason) and (what in run.reason) is (offset[2] == 0)


def test_what_comes_near_only_before_a_node_limits_nothing_after_it(
    stacked_plan: Plan, stacked_scene: Scene, report: Report
) -> None:
    margins = Margins(stacked_plan, with_gaps(report, beside(stacked_plan, "o1", 0.002)))
    after = stacked_plan.nodes[stacked_plan.root].next
    first, second = margins.rest(stacked_plan.root), margins.rest(str(after))
    assert first is not None and second is not None
    assert first.radius("o1").least == 0.002 and first.radius("o1").other == "mobile.gripper_base"
    assert second.radius("o1").least == second.near
    found = {(each.node, each.body): each for each in body_margins(margins, stacked_scene.movable)}
    assert found[stacked_plan.root, "o1"].radius == 0.002
    assert found[stacked_plan.root, "o1"].along[:2] == (0.002, second.near)
    rows = table_of(margins, list(found.values()))
    assert any("o1" in row and "mobile.gripper_base at n0" in row and " 2.0 " in row for row in rows)


def test_gaps_are_told_up_to_twice_the_distance_for_which_a_plan_has_proofs(
    stacked_plan: Plan, report: Report
) -> None:
    margins = Margins(stacked_plan, report)
    assert margins.gaps is not None and margins.far == 2.0 * margins.near
    assert any(margins.near < gap.least < margins.far for gap in margins.gaps)


def test_what_was_passed_in_a_node_limits_nothing_any_more(stacked_plan: Plan, report: Report) -> None:
    root = stacked_plan.root
    gap = beside(stacked_plan, "o1", 0.002, segments=(0,))
    later = beside(stacked_plan, "o1", 0.005, segments=(0, 1))
    margins = Margins(stacked_plan, with_gaps(report, gap, later))
    least = [
        tolerance.radius("o1").least
        for done in ((), ((root, 0),), ((root, 1),), ((root, 0), (root, 1)))
        if (tolerance := margins.rest(root, frozenset(done))) is not None
    ]
    assert least == [0.002, 0.005, 0.002, margins.far]


def test_a_hand_may_move_what_it_closes_on_within_what_is_proven_meanwhile(
    stacked_plan: Plan, stacked_scene: Scene, report: Report
) -> None:
    """A gap of a later motion is judged before that one begins: by then the hand has closed."""
    segments = stacked_plan.nodes[stacked_plan.root].motion
    closing = next(k for k, segment in enumerate(segments) if any(body == "o2" for body, _ in segment.attach))
    last = beside(stacked_plan, "o2", 0.003, segments=(len(segments) - 1,), hands=(ARM, HAND))
    begin, end = segments[closing].times[0], segments[closing].times[-1]

    class Nudged(Moved):
        """Sees the body elsewhere for as long as a hand closes on it, or from a little before that."""

        earlier = 0.0

        def poses(self) -> Mapping[str, Array]:
            time = robot.state().motion_time
            return super().poses() if begin - self.earlier < time < end - 0.02 else robot.poses()

    for earlier, goes_on in ((0.0, True), (0.1, False)):
        robot = KinematicRobot(stacked_scene, rate=100.0)
        sensor = Nudged(robot, {"o2": (0.004, 0.0, 0.0)})
        sensor.earlier = earlier
        run = execute(stacked_plan, stacked_scene, robot, sensor, report=with_gaps(report, last))
        assert run.reached_goal is goes_on, run.reason


def test_directions_count_only_until_a_hand_takes_the_body(stacked_plan: Plan, report: Report) -> None:
    nodes = [name for name, node in stacked_plan.nodes.items() if node.motion]
    takes = {n: {b for s in stacked_plan.nodes[n].motion for b, _ in s.attach} for n in nodes}
    assert "o2" in takes[stacked_plan.root]  # and again in the last node
    margins = Margins(stacked_plan, with_gaps(report, beside(stacked_plan, "o2", 0.002, nodes[-1])))
    tolerance = margins.rest(stacked_plan.root)
    assert tolerance is not None and tolerance.along("o2", -X) == 0.002


def test_a_body_that_is_not_seen_any_more_is_where_it_was_seen_last(
    stacked_plan: Plan, stacked_scene: Scene, report: Report
) -> None:
    """It is what surprises, not a body at its place that it may have come near to."""
    robot = KinematicRobot(stacked_scene, rate=100.0)

    class Lost(Moved):
        def poses(self) -> Mapping[str, Array]:
            found = dict(super().poses())
            return found if robot.time < 0.2 else {name: pose for name, pose in found.items() if name != "o1"}

    watch = Watch(stacked_scene, Margins(stacked_plan, with_gaps(report)))
    belief, sensor = Belief.at_start(stacked_scene, stacked_plan.start), Lost(robot, {"o1": (0.4, 0.0, 0.0)})
    first = watch.bodies(sensor.poses(), robot.state(), belief, stacked_plan.root)
    robot.wait(0.3)
    assert "o1" not in sensor.poses()
    second = watch.bodies(sensor.poses(), robot.state(), belief, stacked_plan.root)
    for surprise, how in ((first, "is"), (second, "was seen last")):
        assert surprise is not None and surprise.thing == "o1"
        assert surprise.sentence.startswith(f"o1 {how} 400.0 mm from where it was put, 20.0 mm are proven")


def test_two_bodies_share_what_is_between_them(stacked_plan: Plan, stacked_scene: Scene, report: Report) -> None:
    gap = beside(stacked_plan, "o2", 0.004, names=("o1", "o2"), hands=(None, HAND))
    both = with_gaps(report, gap)
    apart, together = (0.003, 0.0, 0.0), (-0.003, 0.0, 0.0)
    assert run_with(stacked_plan, stacked_scene, both, {"o1": together}).reached_goal
    assert not run_with(stacked_plan, stacked_scene, both, {"o1": together, "o2": apart}).reached_goal


def test_a_robot_off_its_path_and_a_body_off_its_place_share_a_gap(
    stacked_plan: Plan, stacked_scene: Scene, report: Report
) -> None:
    class Off(KinematicRobot):
        """Its first joint is measured elsewhere while it moves."""

        def state(self) -> RobotState:
            found = super().state()
            q = found.positions["mobile"]
            return replace(found, positions={"mobile": (q[0] + 0.002 * found.moving, *q[1:])})

    def stops(gap: float, offset: float) -> bool:
        robot = Off(stacked_scene, rate=100.0)
        sensor = Moved(robot, {"o1": (offset, 0.0, 0.0)})
        sure = with_gaps(report, beside(stacked_plan, "o1", gap))
        found = execute(stacked_plan, stacked_scene, robot, sensor, report=sure)
        if found.reached_goal:
            return False
        assert found.surprise is not None and "nearer to each other than is proven" in found.reason
        return True

    assert not stops(0.003, 0.0)
    assert stops(0.003, 0.0025)
    assert stops(0.0005, 0.0)


def test_a_tracking_error_counts_where_its_robot_moves_things_nearer(
    stacked_plan: Plan, stacked_scene: Scene, report: Report
) -> None:
    near = with_gaps(report, beside(stacked_plan, "o1", 0.002))
    in_hand = beside(stacked_plan, "o1", 0.002, names=("mobile.left_finger", "o1"), hands=(HAND, HAND))
    assert run_with(stacked_plan, stacked_scene, near, {}, tracking_error=0.001).reached_goal
    with pytest.raises(
        InputError, match="2 mm is proven between mobile.gripper_base and o1 in n0, and robots are up to 3 mm"
    ):
        run_with(stacked_plan, stacked_scene, near, {}, tracking_error=0.003)
    assert run_with(stacked_plan, stacked_scene, near, {}, tracking_error=0.003, despite_margins=True).reached_goal
    assert run_with(stacked_plan, stacked_scene, near, {}, tracking_error={"other": 0.003}).reached_goal
    assert run_with(stacked_plan, stacked_scene, with_gaps(report, in_hand), {}, tracking_error=0.003).reached_goal
    two = beside(stacked_plan, "o1", 0.005, names=("mobile.gripper_base", "mobile.base_link"), hands=(HAND, ARM))
    with pytest.raises(InputError, match="up to 6 mm off"):  # both ends of the pair may be off
        run_with(stacked_plan, stacked_scene, with_gaps(report, two), {}, tracking_error=0.003)


def test_a_tracking_error_is_kept_free_beside_bodies(
    stacked_plan: Plan, stacked_scene: Scene, report: Report
) -> None:
    near = with_gaps(report, beside(stacked_plan, "o1", 0.004))
    offset = {"o1": (0.0025, 0.0, 0.0)}
    assert run_with(stacked_plan, stacked_scene, near, offset, tracking_error=0.001).reached_goal
    assert not run_with(stacked_plan, stacked_scene, near, offset, tracking_error=0.002).reached_goal


def test_the_claims_that_are_kept_imply_all_others() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        axes = rng.normal(size=(300, 3))
        axes /= np.linalg.norm(axes, axis=1)[:, None]
        gaps = rng.uniform(0.001, 0.01, 300)
        kept = essential(tuple(zip(axes, gaps.tolist(), strict=True)))
        assert FEW_CLAIMS < len(kept) < 300 or len(kept) < 300
        shifts, spent = rng.normal(size=(2000, 3)) * 0.006, rng.uniform(0.0, 0.003, 2000)
        u, g = np.array([axis for axis, _ in kept]), np.array([gap for _, gap in kept])
        whole = (gaps - shifts @ axes.T - spent[:, None]).min(axis=1)
        few = (g - shifts @ u.T - spent[:, None]).min(axis=1)
        assert ((few >= 0.0) <= (whole >= 0.0)).all()
        assert ((whole > 1e-6) <= (few >= 0.0)).all()


# ------------------------------------------------------------------------------------------------------- noise
class Noisy(Moved):
    """A camera with noise, 30 pictures a second."""

    def __init__(
        self, robot: KinematicRobot, offsets: Mapping[str, tuple[float, float, float]], noise: PoseNoise, seed: int
    ) -> None:
        super().__init__(robot, offsets)
        self.robot, self.noise, self.seed, self._pictures = robot, noise, seed, 0

    def poses(self) -> Mapping[str, Array]:
        if self.robot.time * 30.0 < self._pictures:
            return {}
        self._pictures += 1
        found = {}
        for number, (name, pose) in enumerate(super().poses().items()):
            drawn = normals(uniforms(stream_key("noisy", self.seed, name), self._pictures, 1, 12)[0])
            found[name] = pose.copy()
            found[name][:3, 3] += self.noise.position * drawn[:3]
            found[name][:3, :3] = rotation(self.noise.angle * drawn[3:]) @ pose[:3, :3]
            assert number < 10
        return found


def noisy_run(plan: Plan, scene: Scene, report: Report, off: float, sigma: float, seed: int) -> Run:
    robot = KinematicRobot(scene, rate=100.0)
    noise = PoseNoise(sigma, 2.0 * sigma)
    return execute(plan, scene, robot, Noisy(robot, {"o1": (off, 0.0, 0.0)}, noise, seed), report=report)


@pytest.mark.parametrize("sigma", [0.0005, 0.001, 0.002])
def test_noise_alone_is_no_surprise_and_more_noise_takes_more_looks(
    sigma: float, stacked_plan: Plan, stacked_scene: Scene, report: Report
) -> None:
    near = with_gaps(report, beside(stacked_plan, "o1", 0.005))
    for seed in range(3):
        run = noisy_run(stacked_plan, stacked_scene, near, 0.0, sigma, seed)
        assert run.reached_goal, run.reason
        first = next(iter(run.log.of("looked")))
        radius = float(np.linalg.norm(stacked_scene.bodies["o1"].mesh.vertices, axis=1).max())
        needed = PoseNoise(sigma, 2.0 * sigma).needed(radius, 0.005)
        assert first["outcome"] == "as planned" and first["bodies"]["o1"] >= min(needed, 2)
        assert first["bodies"]["o1"] <= 8 * needed + 4


def test_a_body_beyond_its_margin_is_found_in_noise_and_one_within_it_goes_on(
    stacked_plan: Plan, stacked_scene: Scene, report: Report
) -> None:
    near = with_gaps(report, beside(stacked_plan, "o1", 0.004))
    for seed in range(4):
        inside = noisy_run(stacked_plan, stacked_scene, near, 0.003, 0.001, seed)
        assert inside.reached_goal, inside.reason
        outside = noisy_run(stacked_plan, stacked_scene, near, 0.005, 0.001, seed)
        assert not outside.reached_goal and outside.surprise is not None and outside.surprise.thing == "o1"
        assert not list(outside.log.of("moving"))  # it was found before anything moved


def test_looks_are_averaged_forget_what_was_before_a_body_moved_and_are_bounded() -> None:
    noise, rng, wanted = PoseNoise(0.001, 0.002), np.random.default_rng(0), np.eye(4)
    looks = Looks(noise)

    def look(off: float) -> tuple[float, int, float]:
        pose = wanted.copy()
        pose[:3, 3] += np.array([off, 0.0, 0.0]) + rng.normal(size=3) * noise.position
        pose[:3, :3] = rotation(rng.normal(size=3) * noise.angle)
        seen = looks.take("o", wanted, pose, None, CUBE)
        return seen.displaced.size, seen.looks, seen.error

    for _ in range(50):
        off, count, error = look(0.0)
    assert count == 50 and off < error < 0.001
    for _ in range(8):
        off, count, error = look(0.01)
    assert count <= 8 and abs(off - 0.01) < error
    for _ in range(200):
        off, count, error = look(0.01)
    assert count == MOST_LOOKS and abs(off - 0.01) < error
    assert noise.needed(0.03, 1e-9) == MOST_LOOKS
    mean = looks.poses({})["o"]
    assert abs(mean[0, 3] - 0.01) < 4e-4
    for _ in range(2):  # where it should be has changed
        seen = looks.take("o", wanted, wanted, "left", CUBE)
    assert seen.looks == 2 and seen.displaced.size < 1e-9


def test_one_picture_counts_once_however_often_it_is_looked_at(stacked_scene: Scene, stacked_plan: Plan) -> None:
    looks, robot = Looks(PoseNoise(0.001)), KinematicRobot(stacked_scene)
    watch = Watch(stacked_scene, Margins(stacked_plan, None), looks=looks)
    belief = Belief(stacked_scene, stacked_scene.start)
    for count in (1, 2, 3):
        for _ in range(2):
            seen = watch.look(robot.poses(), robot.state(), belief)
            assert {each.looks for each in seen.values()} == {count}
        robot.wait(0.01)


def test_a_displacement_is_that_of_the_point_that_moves_farthest() -> None:
    assert Displacement(np.array([0.003, 0.004, 0.0]), 0.002).size == pytest.approx(0.007)
    turned = np.eye(4)
    turned[:3, :3] = rotation(np.array([0.0, 0.0, 0.1]))
    chord = 2.0 * np.sin(0.05) * 0.03 * np.sqrt(2.0 / 3.0)  # of the cube's edges that are parallel to the axis
    assert displacement(np.eye(4), turned, CUBE).size == pytest.approx(chord)
    about_an_edge = turned.copy()
    about_an_edge[:3, 3] = CUBE[0] - turned[:3, :3] @ CUBE[0]
    assert displacement(np.eye(4), about_an_edge, CUBE).size == pytest.approx(2.0 * chord)  # the edge across


@pytest.mark.parametrize("seed", range(20))
def test_no_point_of_a_body_is_displaced_by_more_than_its_corners_say(seed: int) -> None:
    rng, poses = np.random.default_rng(seed), [np.eye(4), np.eye(4)]
    for pose in poses:
        pose[:3, :3], pose[:3, 3] = (
            rotation(rng.normal(size=3) * rng.choice([0.01, 2.0])),
            rng.normal(size=3) * 0.1,
        )
    low, high = np.sort(rng.normal(size=(2, 3)), axis=0)
    corners = np.array(list(product(*zip(low, high, strict=True))))
    points = rng.uniform(low, high, (200, 3))
    moves = (points @ poses[1][:3, :3].T + poses[1][:3, 3]) - (points @ poses[0][:3, :3].T + poses[0][:3, 3])
    found, axes = displacement(poses[0], poses[1], corners), rng.normal(size=(50, 3))
    assert np.linalg.norm(moves, axis=1).max() <= found.size + 1e-12
    assert ((moves @ axes.T).max(axis=0) <= (found.moves @ axes.T).max(axis=0) + 1e-12).all()
