"""Plans anew after a surprise: back to where the node began, then the rest of the plan, then other actions."""

from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field, replace
from functools import partial
from threading import Event
from typing import Literal

from kabo.errors import InputError
from kabo.execution import Answer, Interruption
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.language.problem import Problem
from kabo.options import SolveOptions
from kabo.plan import Plan, State
from kabo.planner.geometry.relations import Relations, changed_relations, event_of, told
from kabo.planner.memo import Memo
from kabo.planner.solve import solve
from kabo.recovery.first_motion import begun_with, first_motion, goes_on, in_a_thread, with_known_parts
from kabo.recovery.node_ways import NoWayError, way_back, way_on, way_open
from kabo.scene import Scene
from kabo.verify.report import Report
from kabo.verify.verification import verify_plan

TIMEOUT = 20.0  # [s] for which robots stand and wait, at most


@dataclass
class Replanner:
    """Answers surprises by plans from where everything is observed to be; each motion is verified before it begins.

    Args:
        problem: the problem.
        scene: its scene, loaded.
        options: of `kabo.solve`; without `timeout` it is 20 s.
        memo: of the solve that made the plan, if there is one: then answers come faster.
    """

    problem: Problem
    scene: Scene
    options: SolveOptions = field(default_factory=dict)  # type: ignore[assignment]
    memo: Memo = field(default_factory=Memo)
    # What makes the last answer, of which the rest may still be to be proven.
    _solving: "Future[Answer] | None" = field(default=None, init=False, repr=False)

    def answer(self, interruption: Interruption) -> Answer:
        """A proven plan from where the run stands, or the reason for having none.

        Of a plan of several motions the first one is proven; the rest gets its times and proofs while that one is carried
        out (`Answer.rest`).
        """
        if self._solving is not None:  # what is kept of a scene is not for two threads
            wait([self._solving])
            self._solving = None
        gone = interruption.surprise.kind == "gone"
        if gone:
            return Answer("none", None, "nobody knows where it is")
        if interruption.executed:
            return self._out_of_the_node(interruption)
        return self._onward(interruption)

    def _changed(self, interruption: Interruption) -> Iterator[tuple[str, Relations, Relations]]:
        """The bodies that are otherwise than the plan has them, with their relations by the plan and now."""
        wanted, found = interruption.expected, interruption.state.geometry
        if wanted is not None and found is not None:
            yield from changed_relations(self.scene, wanted, found)

    def _out_of_the_node(self, interruption: Interruption) -> Answer:
        """On to the end of the node, or back to where it began, or with other motions from the middle of it.

        Where something that is not held is between the fingers of a hand, the hand opens first.
        """
        on, _ = self._way("finish", "on to the end of the node", way_on, interruption)
        if on.plan is not None:
            return on
        back, between = self._way("undo", "back to where the node began", way_back, interruption)
        if back.plan is not None:
            return back
        reasons = [on.reason, back.reason]
        opening = (("back with open hands", way_back), ("out of a contact with open hands", way_open))
        for where, made in opening if between else ():
            found, _ = self._way("undo", where, partial(made, between=between), interruption)
            if found.plan is not None:
                return found
            reasons.append(found.reason)
        with_shifted = partial(way_on, shifted_in_hands=True)  # where another hand has let go, none leads back
        shifted, _ = self._way("finish", "on with what is shifted in a hand", with_shifted, interruption)
        if shifted.plan is not None:
            return shifted
        onward = self._onward(interruption)
        return onward if onward.plan is not None else Answer("none", None, "; ".join([*reasons, onward.reason]))

    def _way(
        self, kind: Literal["finish", "undo"], where: str, made: Callable[..., Plan], interruption: Interruption
    ) -> tuple[Answer, dict[str, str]]:
        """A way that is proven, or the reason why not, with the bodies that are between fingers then and whose."""
        try:
            plan = made(interruption, self.scene, clearance=self.options.get("clearance") or 0.0)
        except (NoWayError, InputError, ValueError) as error:
            return Answer("none", None, f"there is no way {where}: {error}".rstrip("\n")), {}
        assert self.scene.description is not None
        report = verify_plan(self.scene.description, plan, scene=self.scene)
        why = _unproven(plan, report)
        if why is None:
            return Answer(kind, plan, f"the way {where} is proven", report), {}
        text = f"the way {where} is not proven: {why}"
        return Answer("none", None, text), self._between(interruption, report)

    def _between(self, interruption: Interruption, report: Report) -> dict[str, str]:
        """Bodies that stand and meet fingers, by what the verifier has found, each with the robot."""
        assert interruption.state.geometry is not None
        fingers = {
            link: name
            for name, robot in self.scene.robots.items()
            if robot.gripper
            for link in robot.gripper.touch_links
        }
        found = {}
        for finding in report.findings:
            links = [thing for thing in finding.bodies if thing in fingers]
            bodies = [thing for thing in finding.bodies if thing in self.scene.movable]
            if not links or not bodies:
                continue
            parent = interruption.state.geometry.objects[bodies[0]].parent
            if parent == "world" or (bodies[0], fingers[links[0]]) in interruption.lost:
                found[bodies[0]] = fingers[links[0]]
        return found

    def _onward(self, interruption: Interruption) -> Answer:
        state = interruption.state
        for name, before, now in self._changed(interruption):
            event = event_of(self.problem, name, before, now)
            if event is None:
                text = f"{told(name, before, now)}, and the domain has no event that says what is then known of it"
                return Answer("none", None, text)
            state = replace(state, done=(*state.done, event))
        if self.memo.scene is None and self.memo.problem is self.problem:
            self.memo.scene = self.scene
        first, given_up = Future[Answer](), Event()
        self._solving = whole = in_a_thread(
            partial(self._solved, state, interruption.plan, first, given_up.is_set)
        )
        try:
            wait((first, whole), return_when=FIRST_COMPLETED)
        finally:
            if not (first.done() or whole.done()):  # by Ctrl-C: the process ends with its threads
                given_up.set()
        return replace(first.result(), rest=whole.result) if first.done() else whole.result()

    def _solved(
        self, state: State, earlier: Plan, first: "Future[Answer]", given_up: Callable[[], bool] = lambda: False
    ) -> Answer:
        """A plan that is proven, or why there is none; `first` has its begin, as soon as the first motion is proven."""

        def begun(plan: Plan, surroundings: SceneSurroundings) -> None:
            begin = first_motion(plan, self.scene)
            if begin is not None:
                self._tell(first, plan, with_known_parts(begin, surroundings, earlier))

        options: SolveOptions = {"timeout": TIMEOUT}
        options.update(self.options)
        try:
            result = solve(
                self.problem, start=state, memo=self.memo, cancelled=given_up, on_first=begun, **options
            )
        except InputError as error:
            return Answer("none", None, str(error).rstrip("\n"))
        plan = result.plan
        if plan is None:
            reason = result.reason
            more = "" if reason is None or not reason.details else f" ({reason.details[0]})"
            return Answer("none", None, ("no plan was found" if reason is None else reason.message) + more)
        if not first.done() and (begin := first_motion(plan, self.scene)):  # of a plan that was foreseen
            self._tell(first, plan, begin)
        if first.done() and not goes_on(first.result().plan, plan):
            return Answer("none", None, "the new plan does not begin with the motion that was proven")
        report = verify_plan(self.problem, plan, start=state, scene=self.scene)
        why = _unproven(plan, report)
        if why is not None:
            return Answer("none", None, f"the new plan is not proven: {why}")
        return self._found(plan, report, "are proven")

    def _tell(self, told: "Future[Answer]", plan: Plan, first: Plan) -> None:
        """Answers with the begin of a plan, if its first motion is proven."""
        assert self.scene.description is not None
        report = verify_plan(self.scene.description, first, scene=self.scene, meshes=False)
        if _unproven(first, report) is None:
            told.set_result(self._found(begun_with(plan, first), report, "begin with a motion that is proven,"))

    def _found(self, plan: Plan, report: Report, told: str) -> Answer:
        if self.memo.continued:
            return Answer("repair", plan, f"the same actions {told} from where everything is now", report)
        return Answer("replan", plan, f"other actions {told} from where everything is now", report)


def _unproven(plan: Plan, report: Report) -> str | None:
    """Why a plan may not be carried out; one without a certificate has no margins, and the least error would stop it."""
    if not report.ok:
        return report.findings[0].message
    if plan.certificate is None and any(node.motion for node in plan.nodes.values()):
        return next(iter(plan.certificate_gaps), "it has no certificate")
    return None
