"""Plans anew after a surprise: back to where the node began, then the rest of the plan, then other actions."""

from dataclasses import dataclass, field

from kabo.errors import InputError
from kabo.execution import Answer, Interruption
from kabo.language.problem import Problem
from kabo.options import SolveOptions
from kabo.planner.memo import Memo
from kabo.planner.solve import solve
from kabo.recovery.undoing import NoWayBackError, undoing_plan
from kabo.scene import Scene
from kabo.verify.verification import verify_plan

TIMEOUT = 20.0  # [s] for which robots stand and wait, at most


@dataclass
class Replanner:
    """Answers surprises by plans from where everything is observed to be; each is verified first.

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

    def answer(self, interruption: Interruption) -> Answer:
        """A proven plan from where the run stands, or the reason for having none."""
        gone = interruption.surprise.kind == "gone"
        if gone:
            return Answer("none", None, "nobody knows where it is")
        if interruption.executed:
            return self._undo(interruption)
        return self._onward(interruption)

    def _undo(self, interruption: Interruption) -> Answer:
        try:
            plan = undoing_plan(interruption, self.scene, clearance=self.options.get("clearance") or 0.0)
        except NoWayBackError as error:
            return Answer("none", None, f"there is no way back: {error}")
        except (InputError, ValueError) as error:
            return Answer("none", None, f"there is no way back: {error}".rstrip("\n"))
        assert self.scene.description is not None
        report = verify_plan(self.scene.description, plan)
        if not report.ok:
            return Answer("none", None, f"the way back is not proven: {report.findings[0].message}")
        return Answer("undo", plan, "the way back to where the node began is proven")

    def _onward(self, interruption: Interruption) -> Answer:
        state = interruption.state
        options: SolveOptions = {"timeout": TIMEOUT}
        options.update(self.options)
        try:
            result = solve(self.problem, start=state, memo=self.memo, **options)
        except InputError as error:
            return Answer("none", None, str(error).rstrip("\n"))
        if result.plan is None:
            reason = result.reason
            more = "" if reason is None or not reason.details else f" ({reason.details[0]})"
            return Answer("none", None, ("no plan was found" if reason is None else reason.message) + more)
        report = verify_plan(self.problem, result.plan, start=state)
        if not report.ok:
            return Answer("none", None, f"the new plan is not proven: {report.findings[0].message}")
        if self.memo.continued:
            return Answer("repair", result.plan, "the same actions are proven from where everything is now")
        return Answer("replan", result.plan, "other actions are proven from where everything is now")
