"""The engine `kabo` of unified-planning: a one-shot planner for classical, numeric and contingent problems.

What kabo cannot plan for is refused by name, before anything is searched; that there is no plan is only said to be
proven where kabo proves it.
"""

from collections.abc import Iterable
from typing import Any
from warnings import warn

from unified_planning.engines import Credits, Engine, LogMessage, PlanGenerationResult
from unified_planning.engines import LogLevel as Level
from unified_planning.engines import PlanGenerationResultStatus as Status
from unified_planning.engines.mixins import OneshotPlannerMixin
from unified_planning.engines.mixins.oneshot_planner import OptimalityGuarantee
from unified_planning.engines.plan_validator import SequentialPlanValidator
from unified_planning.exceptions import UPUsageError
from unified_planning.model import AbstractProblem, ContingentProblem, ProblemKind

from kabo.errors import InputError
from kabo.options import SolveOptions
from kabo.planner.result import Result
from kabo.planner.solve import solve
from kabo.up.kinds import refusals, supported_kind
from kabo.up.plans import plan_to_up
from kabo.up.problems import Translation, problem_from_up
from kabo.up.registration import NAME

_CREDITS = Credits(
    NAME,
    "The kabo contributors",
    "",
    "",
    "Apache-2.0",
    "kabo plans with what is known: sensing, branches, and motions for robots.",
    "kabo searches on the knowledge level and returns plans that branch on what is sensed. Without geometry, as for\n"
    "problems of unified-planning, it is a classical, numeric and contingent planner.",
)
_SPENT = {"time": Status.TIMEOUT, "memory": Status.MEMOUT}


class KaboEngine(Engine, OneshotPlannerMixin):  # type: ignore[misc]  # unified-planning has no types
    """kabo as `OneshotPlanner(name="kabo", params={"search": "astar"})`; `params` are options of `kabo.solve`."""

    def __init__(self, **options: Any) -> None:
        Engine.__init__(self)
        OneshotPlannerMixin.__init__(self)
        self.options: SolveOptions = {"seed": 0}
        self.options.update(options)  # type: ignore[typeddict-item]  # `solve` refuses unknown ones by name

    @property
    def name(self) -> str:
        """`kabo`."""
        return NAME

    @staticmethod
    def supported_kind() -> ProblemKind:
        """The features that kabo supports."""
        return supported_kind()

    @staticmethod
    def supports(problem_kind: ProblemKind) -> bool:
        """Whether kabo supports all features of a kind of problems."""
        return bool(problem_kind <= supported_kind())

    @staticmethod
    def satisfies(optimality_guarantee: OptimalityGuarantee) -> bool:
        """Whether kabo's plans are as good as is asked for: only `params={"search": "astar"}` makes them optimal."""
        return bool(optimality_guarantee == OptimalityGuarantee.SATISFICING)

    @staticmethod
    def get_credits(**kwargs: Any) -> Credits:
        """Who made kabo."""
        return _CREDITS

    def solve(self, problem: AbstractProblem, *arguments: Any, **options: Any) -> PlanGenerationResult:
        """Plans as every one-shot planner does; what kabo does not support is refused with the reasons.

        unified-planning asks for errors only of engines that it chose itself; one that is named answers
        UNSUPPORTED_PROBLEM.

        Raises:
            UPUsageError: kabo does not support the problem, and `error_on_failed_checks` is set; says why.
        """
        refused = refusals(problem.kind)
        if refused and self.error_on_failed_checks and not self.skip_checks:
            raise UPUsageError(f"kabo does not support this problem: {'; '.join(refused)}")
        if refused:
            return _unsupported(refused)
        return super().solve(problem, *arguments, **options)

    def _solve(
        self,
        problem: AbstractProblem,
        heuristic: Any = None,
        timeout: float | None = None,
        output_stream: Any = None,
    ) -> PlanGenerationResult:
        """Called by `solve` of unified-planning."""
        ignored = {"heuristic": heuristic, "output_stream": output_stream}
        for name, given in ignored.items():
            if given is not None:
                warn(f"kabo does not use the argument {name}", stacklevel=2)
        options: SolveOptions = {**self.options}
        if timeout is not None:
            options["timeout"] = timeout
        try:
            translation = problem_from_up(problem)
            result = solve(translation.problem, **options)
            return self._answer(translation, result)
        except InputError as error:
            return _unsupported(each.message for each in error.diagnostics)

    def _answer(self, translation: Translation, result: Result) -> PlanGenerationResult:
        """Kabo's result as one of unified-planning."""
        problem, statistics = translation.original, result.statistics
        figures = {"expanded": str(statistics["expanded"]), "engine_internal_time": str(statistics["total_s"])}
        if result.plan is None:
            status, log = _without_plan(translation, result)
            return PlanGenerationResult(status, None, NAME, figures, log)
        plan = plan_to_up(result.plan, translation)
        contingent = isinstance(problem, ContingentProblem)
        if not translation.exact and not contingent and not _is_valid(problem, plan):
            text = "the plan that was found holds in floating point, but not in exact arithmetic"
            return PlanGenerationResult(
                Status.UNSOLVABLE_INCOMPLETELY, None, NAME, figures, [LogMessage(Level.WARNING, text)]
            )
        optimal = self.options.get("search") == "astar" and not contingent and translation.exact
        kind = problem.kind
        optimal = (
            optimal and kind.has_quality_metrics() and not (kind.has_int_fluents() or kind.has_real_fluents())
        )
        return PlanGenerationResult(
            Status.SOLVED_OPTIMALLY if optimal else Status.SOLVED_SATISFICING, plan, NAME, figures
        )


def _unsupported(sentences: Iterable[str]) -> PlanGenerationResult:
    found = [LogMessage(Level.ERROR, each) for each in sentences]
    return PlanGenerationResult(Status.UNSUPPORTED_PROBLEM, None, NAME, log_messages=found)


def _without_plan(translation: Translation, result: Result) -> tuple[Status, list[LogMessage]]:
    """Why there is no plan: a proof, a spent budget, or neither of them."""
    reason = result.reason
    sentences = [] if reason is None else [reason.message, *reason.details]
    proved = result.status == "no_plan" and reason is not None and reason.proved is not None
    if proved and translation.exact:
        status = Status.UNSOLVABLE_PROVEN
    else:
        status = _SPENT.get(str(reason and reason.budget), Status.UNSOLVABLE_INCOMPLETELY)
        if proved:
            sentences.append("this is no proof: numbers are not exact in floating point")
    return status, [LogMessage(Level.INFO, each) for each in sentences]


def _is_valid(problem: Any, plan: Any) -> bool:
    """Whether the plan holds in exact arithmetic, by unified-planning's own validator."""
    validator = SequentialPlanValidator()
    validator.skip_checks = True
    return bool(validator.validate(problem, plan).status)
