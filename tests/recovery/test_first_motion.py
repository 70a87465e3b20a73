"""A new plan begins when its first motion is proven; nothing goes on before all of it is."""

import importlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.execution import Answer, Interruption, KinematicRobot, KnownTruth, Run, execute
from kabo.plan import BodyParts, Plan
from kabo.recovery import Replanner
from kabo.recovery.first_motion import begun, first_motion, stating, with_parts_of
from kabo.scene import Attachment, Scene

DOMAINS = Path(__file__).parents[2] / "domains"
NAMES = ["stacked/n2.yaml", "circular_rearrange/n2.yaml", "force_sensing/n1.yaml", "inspection/three_boxes.yaml"]


def solved(name: str) -> tuple[kabo.Problem, Scene, Plan]:
    problem = kabo.load_problem(DOMAINS / name)
    plan = kabo.solve(problem).plan
    assert plan is not None
    return problem, kabo.load_scene(problem.scene), plan


@pytest.fixture(scope="module")
def stacked() -> tuple[kabo.Problem, Scene, Plan]:
    return solved(NAMES[0])


def shaken(plan: Plan, node: str) -> Plan:
    """The plan with a node whose last joint is elsewhere in the middle of its first trajectory."""
    first, *others = plan.nodes[node].motion
    assert first.trajectory is not None
    pieces = [np.array(piece) for piece in first.trajectory.coefficients]
    pieces[len(pieces) // 2][-1, 0] += 0.3
    motion = (replace(first, trajectory=replace(first.trajectory, coefficients=tuple(pieces))), *others)
    return replace(plan, nodes={**plan.nodes, node: replace(plan.nodes[node], motion=motion)})


@pytest.mark.parametrize("name", NAMES)
def test_the_first_motion_is_proven_by_itself_with_the_same_gaps(name: str) -> None:
    problem, scene, plan = solved(name)
    first = first_motion(plan, scene)
    assert first is not None and plan.root == first.root
    alone, whole = kabo.verify(scene, first), kabo.verify(problem, plan, scene=scene)
    assert alone.ok, alone
    assert alone.certificate is not None and whole.certificate is not None
    nodes = {gap.node for gap in alone.certificate.gaps}
    assert nodes <= {name for name in first.nodes if first.nodes[name].motion} and len(first.nodes) < len(
        plan.nodes
    )
    told = [(gap.node, gap.names, gap.segments, gap.least) for gap in whole.certificate.gaps if gap.node in nodes]
    assert told == [(gap.node, gap.names, gap.segments, gap.least) for gap in alone.certificate.gaps]
    assert not kabo.verify(scene, shaken(first, first.root)).ok


def _looked_at(*_: object) -> None:
    raise LookupError("it was asked whether parts enclose a body")


def repaired(name: str) -> tuple[kabo.Problem, Scene, Plan, Plan]:
    """A problem, its scene, its plan, and the plan of its goal from where the first node has begun elsewhere."""
    problem, scene, plan = solved(name)
    state = kabo.after(problem, plan, [])
    assert state.geometry is not None
    moved = {}
    for body, own in state.geometry.objects.items():
        x, y, z = own.position
        moved[body] = replace(own, position=(x + 0.004, y, z)) if own.parent == "world" else own
    state = replace(state, geometry=replace(state.geometry, objects=moved))
    new = kabo.solve(problem, start=state).plan
    assert new is not None
    return problem, scene, plan, new


def test_parts_that_are_known_to_enclose_the_bodies_are_not_looked_at_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    problem, scene, plan, new = repaired("circular_rearrange/n2.yaml")
    cut_out = first_motion(new, scene)
    assert cut_out is not None and cut_out.certificate is not None and plan.certificate is not None
    parts = importlib.import_module("kabo.verify.certificate.parts")
    parts._COVERED.clear()
    assert kabo.verify(problem, plan, scene=scene).ok
    monkeypatch.setattr(parts, "uncovered", _looked_at)
    first = with_parts_of(plan, cut_out, scene)
    assert first.certificate is not None
    assert all(own == plan.certificate.bodies.get(key, own) for key, own in first.certificate.bodies.items())
    report = kabo.verify(scene, first)
    assert report.ok and report.certificate is not None, report
    with pytest.raises(LookupError):  # the plan has parts of its own
        kabo.verify(scene, cut_out)
    monkeypatch.undo()
    stated = stating(new, first)
    assert kabo.verify(problem, stated, start=kabo.State((), new.start), scene=scene).ok
    assert stated.certificate is not None
    least = {each.segment: each.clearance for each in first.certificate.segments}
    for each in stated.certificate.segments:
        if each.node == new.root and least[each.segment] is not None:
            assert each.clearance is not None and each.clearance <= least[each.segment]


def test_parts_that_do_not_suffice_are_not_used(stacked: tuple[kabo.Problem, Scene, Plan]) -> None:
    _, scene, plan = stacked
    first = first_motion(plan, scene)
    assert first is not None and plan.certificate is not None
    corners = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    huge = BodyParts((8,), corners.astype("<f8").tobytes())
    coarse = replace(plan.certificate, bodies=dict.fromkeys(plan.certificate.bodies, huge))
    assert with_parts_of(replace(plan, certificate=coarse), first, scene) is first
    assert first.certificate is not None
    segments = tuple(replace(each, clearance=5.0) for each in first.certificate.segments)
    tight = replace(first, certificate=replace(first.certificate, segments=segments))
    assert with_parts_of(plan, tight, scene) is tight, "much less is proven with other parts"
    assert with_parts_of(replace(plan, certificate=None), first, scene) is first


def test_a_plan_of_one_motion_has_no_first_one(stacked: tuple[kabo.Problem, Scene, Plan]) -> None:
    _, scene, plan = stacked
    last = next(name for name, node in plan.nodes.items() if node.motion and not plan.nodes[str(node.next)].motion)
    rest = {name: plan.nodes[name] for name in (last, str(plan.nodes[last].next))}
    assert first_motion(replace(plan, root=last, nodes=rest), scene) is None
    assert first_motion(replace(plan, certificate=None), scene) is None


def test_a_motion_into_which_the_next_one_begins_is_proven_with_the_whole_plan() -> None:
    problem = kabo.load_problem(DOMAINS / "circular_rearrange" / "n3.yaml")
    first = kabo.solve(problem).plan
    assert first is not None and problem.scene is not None
    state, scene = kabo.after(problem, first, []), kabo.load_scene(problem.scene)
    plan = kabo.solve(problem, start=state, quality="good").plan
    assert plan is not None
    following = plan.nodes[str(plan.nodes[plan.root].next)]
    assert following.overlap > 0.0 and first_motion(plan, scene) is None
    answer = Replanner(problem, scene)._proven(plan, state, first)
    assert answer.plan is plan and answer.rest is None, answer.reason


class Shifting(KinematicRobot):
    """A robot in whose world a body is elsewhere from a time on."""

    def wait(self, seconds: float) -> None:
        super().wait(seconds)
        own = self.world.objects["o1"]
        if self.time >= 0.4 and own.parent == "world" and own.position == self.scene.start.objects["o1"].position:
            x, y, z = own.position
            self.world = self.world.replace({"o1": Attachment("world", (x + 0.014, y, z), own.quaternion)})


class Careless(Replanner):
    """Spoils a node of each plan that it finds, before anything is proven."""

    spoilt = 0  # the number of the node

    def _proven(self, plan: Plan, state: kabo.State, earlier: Plan) -> Answer:
        names = [name for name, node in plan.nodes.items() if node.motion]
        return super()._proven(shaken(plan, names[min(self.spoilt, len(names) - 1)]), state, earlier)


def carried_out(case: tuple[kabo.Problem, Scene, Plan], recovery: Replanner) -> Run:
    _, scene, plan = case
    robot = Shifting(scene)
    return execute(plan, scene, robot, KnownTruth(poses=robot.poses), recovery=recovery)


def test_what_is_not_proven_is_not_begun(stacked: tuple[kabo.Problem, Scene, Plan]) -> None:
    recovery = Careless(stacked[0], stacked[1])
    run = carried_out(stacked, recovery)
    assert not run.reached_goal and "the new plan is not proven" in run.reason


def test_a_plan_without_a_certificate_is_not_begun(stacked: tuple[kabo.Problem, Scene, Plan]) -> None:
    """It has no margins: the least error of what is measured would end it in the midst of a motion."""

    class Without(Replanner):
        def _proven(self, plan: Plan, state: kabo.State, earlier: Plan) -> Answer:
            plan = replace(plan, certificate=None, certificate_gaps=("n0: too near",))
            return super()._proven(plan, state, earlier)

    run = carried_out(stacked, Without(*stacked[:2]))
    assert not run.reached_goal and run.reason.endswith("the new plan is not proven: n0: too near")


def test_nothing_goes_on_before_the_rest_is_proven(stacked: tuple[kabo.Problem, Scene, Plan]) -> None:
    recovery = Careless(stacked[0], stacked[1])
    recovery.spoilt = 1
    run = carried_out(stacked, recovery)
    assert not run.reached_goal and run.surprise is not None
    assert "the rest of the plan is not proven" in run.reason
    records = [(each["event"], each.get("rest")) for each in run.log.records]
    proven = [number for number, each in enumerate(records) if each == ("proven", False)]
    assert proven and ("proven", True) not in records
    followed = {"moving", "followed", "gripping", "releasing"}
    for number in proven:  # the robot rests until there is an answer, and after the last one it never moves
        until = next((k for k in range(number, len(records)) if records[k][0] == "answer"), len(records))
        assert not followed & {event for event, _ in records[number:until]}
    assert not followed & {event for event, _ in records[proven[-1] :]}


def test_a_run_is_the_same_however_long_the_proof_of_the_rest_takes(
    stacked: tuple[kabo.Problem, Scene, Plan],
) -> None:
    class Whole(Replanner):
        """Proves the rest before it answers."""

        def answer(self, interruption: Interruption) -> Answer:
            found = super().answer(interruption)
            if found.rest is not None:
                report = found.rest()
                assert report.ok
            return found

    runs = [carried_out(stacked, kind(*stacked[:2])) for kind in (Replanner, Whole)]
    assert runs[0].reached_goal and runs[0].log.records == runs[1].log.records
    assert [each["rest"] for each in runs[0].log.of("proven")] == [True]


def test_an_error_of_a_proof_is_raised_where_it_is_waited_for() -> None:
    def check() -> kabo.Report:
        raise OSError("no such file")

    with pytest.raises(OSError, match="no such file"):
        begun(check).result()
