"""Plans anew after a surprise: back to where the node began, then the rest of the plan, then other actions."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Literal

from kabo.errors import InputError
from kabo.execution import Answer, Interruption
from kabo.language.problem import Problem
from kabo.options import SolveOptions
from kabo.plan import Plan
from kabo.planner.memo import Memo
from kabo.planner.solve import solve
from kabo.recovery.node_ways import NoWayError, way_back, way_on
from kabo.recovery.relations import Relations, event_of, relations, told
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
            return self._out_of_the_node(interruption)
        return self._onward(interruption)

    def _changed(self, interruption: Interruption) -> Iterator[tuple[str, Relations, Relations]]:
        """The bodies that are otherwise than the plan has them, with their relations by the plan and now."""
        wanted, found = interruption.expected, interruption.state.geometry
        if wanted is not None and found is not None:
            before, now = relations(self.scene, wanted), relations(self.scene, found)
            yield from ((name, before[name], now[name]) for name in before if before[name] != now[name])

    def _out_of_the_node(self, interruption: Interruption) -> Answer:
        """On to the end of the node, or back to where it began."""
        on = self._way("finish", way_on, interruption)
        if on.plan is not None:
            return on
        back = self._way("undo", way_back, interruption)
        return back if back.plan is not None else Answer("none", None, f"{on.reason}; {back.reason}")

    def _way(
        self, kind: Literal["finish", "undo"], made: Callable[..., Plan], interruption: Interruption
    ) -> Answer:
        where = "on to the end of the node" if kind == "finish" else "back to where the node began"
        try:
            plan = made(interruption, self.scene, clearance=self.options.get("clearance") or 0.0)
        except (NoWayError, InputError, ValueError) as error:
            return Answer("none", None, f"there is no way {where}: {error}".rstrip("\n"))
        assert self.scene.description is not None
        report = verify_plan(self.scene.description, plan, scene=self.scene)
        if not report.ok:
            return Answer("none", None, f"the way {where} is not proven: {report.findings[0].message}")
        return Answer(kind, plan, f"the way {where} is proven", report)

    def _onward(self, interruption: Interruption) -> Answer:
        state = interruption.state
        for name, before, now in self._changed(interruption):
            event = event_of(self.problem, name, before, now)
            if event is None:
                text = f"{told(name, before, now)}, and the domain has no event that says what is then known of it"
                return Answer("none", None, text)
            state = replace(state, done=(*state.done, event))
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
        report = verify_plan(self.problem, result.plan, start=state, scene=self.scene)
        if not report.ok:
            return Answer("none", None, f"the new plan is not proven: {report.findings[0].message}")
        if self.memo.continued:
            return Answer(
                "repair", result.plan, "the same actions are proven from where everything is now", report
            )
        return Answer("replan", result.plan, "other actions are proven from where everything is now", report)
