"""A new plan begins when its first motion is proven; nothing goes on before all of it is."""

import importlib
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path
from threading import Event
from time import sleep
from typing import Any

import numpy as np
import pytest

import kabo
from kabo.errors import InputError
from kabo.execution import Answer, Interruption, KinematicRobot, KnownTruth, Run, execute
from kabo.geometry_server import GeometryServer
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.plan import BodyParts, Plan
from kabo.recovery import Replanner, replanning
from kabo.recovery.first_motion import begun_with, first_motion, goes_on, in_a_thread, with_known_parts
from kabo.scene import Attachment, Scene, beginning_at

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
    """The plan with a node whose last joint is elsewhere in the middle of its first trajectory, if it has one."""
    first, *others = plan.nodes[node].motion
    if first.trajectory is None:
        return plan
    pieces = [np.array(piece) for piece in first.trajectory.coefficients]
    pieces[len(pieces) // 2][-1, 0] += 0.3
    motion = (
        replace(
            first,
            trajectory=replace(
                first.trajectory, coefficients=tuple(tuple(map(tuple, piece.tolist())) for piece in pieces)
            ),
        ),
        *others,
    )
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
    told = {(gap.node, gap.names, gap.segments, gap.least) for gap in whole.certificate.gaps if gap.node in nodes}
    assert told == {(gap.node, gap.names, gap.segments, gap.least) for gap in alone.certificate.gaps}
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


def parts_in(scene: Scene, plan: Plan) -> SceneSurroundings:
    assert plan.start is not None
    return GeometryServer(beginning_at(scene, plan.start), scene.epsilon).surroundings


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
    first = with_known_parts(replace(cut_out, certificate=None), parts_in(scene, new), plan)
    assert first.certificate is not None
    assert all(own == plan.certificate.bodies.get(key, own) for key, own in first.certificate.bodies.items())
    report = kabo.verify(scene, first)
    assert report.ok and report.certificate is not None, report
    with pytest.raises(LookupError):  # the plan has parts of its own
        kabo.verify(scene, cut_out)


def test_parts_that_do_not_suffice_are_not_used(
    stacked: tuple[kabo.Problem, Scene, Plan], monkeypatch: pytest.MonkeyPatch
) -> None:
    _, scene, plan = stacked
    first = first_motion(replace(plan, certificate=None), scene)
    assert first is not None and plan.certificate is not None
    surroundings = parts_in(scene, plan)
    own = with_known_parts(first, surroundings, replace(plan, certificate=None)).certificate
    assert own is not None
    corners = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    huge = BodyParts((8,), corners.astype("<f8").tobytes())
    coarse = replace(plan.certificate, bodies=dict.fromkeys(plan.certificate.bodies, huge))
    assert with_known_parts(first, surroundings, replace(plan, certificate=coarse)).certificate == own
    for share, serves in ((0.5, False), (0.9, True)):
        least = share * min(each.clearance or np.inf for each in own.segments)
        less = replace(own, segments=tuple(replace(each, clearance=least) for each in own.segments))
        monkeypatch.setattr("kabo.recovery.first_motion.certificate_with_parts", lambda *_, less=less: less)
        assert with_known_parts(first, surroundings, plan).certificate == (less if serves else own)


def test_a_plan_of_one_motion_has_no_first_one(stacked: tuple[kabo.Problem, Scene, Plan]) -> None:
    _, scene, plan = stacked
    last = next(name for name, node in plan.nodes.items() if node.motion and not plan.nodes[str(node.next)].motion)
    rest = {name: plan.nodes[name] for name in (last, str(plan.nodes[last].next))}
    assert first_motion(replace(plan, root=last, nodes=rest), scene) is None


def test_a_plan_goes_on_as_it_begins_or_is_another_one(stacked: tuple[kabo.Problem, Scene, Plan]) -> None:
    _, scene, plan = stacked
    first = first_motion(plan, scene)
    assert first is not None
    begin = begun_with(plan, first)
    assert begin.certificate == first.certificate and begin.nodes.keys() == plan.nodes.keys()
    assert begin.nodes[plan.root] == plan.nodes[plan.root]
    assert not any(node.motion for name, node in begin.nodes.items() if name != plan.root)
    assert goes_on(begin, plan) and not goes_on(None, plan)
    assert not goes_on(begin, shaken(plan, plan.root)), "another motion"
    goal = next(name for name, node in plan.nodes.items() if node.kind == "goal")
    shorter = {**plan.nodes, plan.root: replace(plan.nodes[plan.root], next=goal)}
    assert not goes_on(begin, replace(plan, nodes=shorter)), "other actions"


@pytest.mark.parametrize("quality", ["fast", "good"])
def test_a_solve_tells_the_first_motion_before_the_others_are_proven(quality: Any) -> None:
    told: list[tuple[Plan, SceneSurroundings]] = []
    problem = kabo.load_problem(DOMAINS / "stacked" / "n2.yaml")
    plan = kabo.solve(problem, quality=quality, on_first=lambda *given: told.append(given)).plan
    ((begin, _),) = told
    assert plan is not None and plan.certificate is not None and begin.certificate is None
    timed = {name for name, node in begin.nodes.items() if node.motion and node.motion[0].trajectory is not None}
    moved = {name for name, node in begin.nodes.items() if node.motion}
    assert timed == ({begin.root} if quality == "fast" else moved), "times of others are for later"
    assert goes_on(begin, plan)
    assert plan == kabo.solve(problem, quality=quality).plan


def test_a_motion_into_which_the_next_one_begins_is_proven_with_the_whole_plan() -> None:
    problem = kabo.load_problem(DOMAINS / "circular_rearrange" / "n3.yaml")
    first = kabo.solve(problem).plan
    assert first is not None and problem.scene is not None
    state, scene = kabo.after(problem, first, []), kabo.load_scene(problem.scene)
    begun: Future[Answer] = Future()
    answer = Replanner(problem, scene, {"quality": "good", "timeout": 600.0})._solved(state, first, begun)
    plan = answer.plan
    assert plan is not None and answer.report is not None and answer.report.ok, answer.reason
    following = plan.nodes[str(plan.nodes[plan.root].next)]
    assert following.overlap > 0.0 and first_motion(plan, scene) is None and not begun.done()


class Shifting(KinematicRobot):
    """A robot in whose world a body is elsewhere from a time on."""

    def wait(self, seconds: float) -> None:
        super().wait(seconds)
        own = self.world.objects["o1"]
        if self.time >= 0.4 and own.parent == "world" and own.position == self.scene.start.objects["o1"].position:
            x, y, z = own.position
            self.world = self.world.replace({"o1": Attachment("world", (x + 0.014, y, z), own.quaternion)})


def spoiling(monkeypatch: pytest.MonkeyPatch, spoilt: Callable[[Plan], Plan]) -> None:
    """Each plan that is found anew is spoilt before anything of it is proven."""

    def solve(problem: kabo.Problem, *, on_first: Any, **more: Any) -> kabo.Result:
        result = kabo.solve(problem, on_first=lambda plan, parts: on_first(spoilt(plan), parts), **more)
        return result if result.plan is None else replace(result, plan=spoilt(result.plan))

    monkeypatch.setattr(replanning, "solve", solve)


def shaking(number: int) -> Callable[[Plan], Plan]:
    def spoilt(plan: Plan) -> Plan:
        names = [name for name, node in plan.nodes.items() if node.motion]
        return shaken(plan, names[min(number, len(names) - 1)])

    return spoilt


def carried_out(case: tuple[kabo.Problem, Scene, Plan], recovery: Replanner) -> Run:
    _, scene, plan = case
    robot = Shifting(scene)
    return execute(plan, scene, robot, KnownTruth(poses=robot.poses), recovery=recovery)


def test_what_is_not_proven_is_not_begun(
    stacked: tuple[kabo.Problem, Scene, Plan], monkeypatch: pytest.MonkeyPatch
) -> None:
    spoiling(monkeypatch, shaking(0))
    run = carried_out(stacked, Replanner(*stacked[:2]))
    assert not run.reached_goal and "the new plan is not proven" in run.reason


def test_a_plan_without_a_certificate_is_not_begun(
    stacked: tuple[kabo.Problem, Scene, Plan], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It has no margins: the least error of what is measured would end it in the midst of a motion."""

    def without(first: Plan, *_: object) -> Plan:
        return replace(first, certificate_gaps=("n0: too near",))

    monkeypatch.setattr(replanning, "with_known_parts", without)
    spoiling(monkeypatch, lambda plan: replace(plan, certificate=None, certificate_gaps=("n0: too near",)))
    run = carried_out(stacked, Replanner(*stacked[:2]))
    assert not run.reached_goal and run.reason.endswith("the new plan is not proven: n0: too near")


def test_a_plan_that_goes_on_otherwise_is_given_up(
    stacked: tuple[kabo.Problem, Scene, Plan], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(replanning, "goes_on", lambda *_: False)
    run = carried_out(stacked, Replanner(*stacked[:2]))
    assert [each["rest"] for each in run.log.of("proven")] == [False]
    kinds = [each["kind"] for each in run.log.of("answer")]
    assert kinds == ["finish", "replan", "repair"], "from where the first motion has ended it is asked again"


def test_nothing_goes_on_before_the_rest_is_proven(
    stacked: tuple[kabo.Problem, Scene, Plan], monkeypatch: pytest.MonkeyPatch
) -> None:
    spoiling(monkeypatch, shaking(1))
    run = carried_out(stacked, Replanner(*stacked[:2]))
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
                whole = found.rest()
                assert whole.report is not None and whole.report.ok
            return found

    runs = [carried_out(stacked, kind(*stacked[:2])) for kind in (Replanner, Whole)]
    assert runs[0].reached_goal and runs[0].log.records == runs[1].log.records
    assert [each["rest"] for each in runs[0].log.of("proven")] == [True]


def test_an_error_of_a_proof_is_raised_where_it_is_waited_for() -> None:
    def check() -> kabo.Report:
        raise OSError("no such file")

    with pytest.raises(OSError, match="no such file"):
        in_a_thread(check).result()


def test_a_search_ends_when_the_run_that_waits_for_it_is_interrupted(
    stacked: tuple[kabo.Problem, Scene, Plan], monkeypatch: pytest.MonkeyPatch
) -> None:
    ended = Event()

    def solve(*_: object, cancelled: Callable[[], bool], **__: object) -> kabo.Result:
        while not cancelled():
            sleep(0.001)
        ended.set()
        raise InputError([])

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(replanning, "solve", solve)
    monkeypatch.setattr(replanning, "wait", interrupted)
    with pytest.raises(KeyboardInterrupt):
        carried_out(stacked, Replanner(*stacked[:2]))
    assert ended.wait(10.0)
