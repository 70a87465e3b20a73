"""Explains, as sentences for users, why a problem has no plan, and which parts of it are useless.

`explain` grounds the whole problem and first computes the delete relaxation. Goal conjuncts that the relaxation
does not reach are proven unreachable, whatever geometry says, and their root causes are reported. If the
relaxation reaches the whole goal, `explain` searches for a symbolic plan, and if there is one, for motions. If
there are no motions, it examines the failed calls and solves the problem again with single changes.
"""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from time import perf_counter
from typing import TYPE_CHECKING, Any, Literal, get_type_hints

from kabo.budgets import StopFlag, default_memory
from kabo.displays import bullets, counted, display, shortened
from kabo.errors import InputError, did_you_mean
from kabo.explain.findings import Counterfactual, Finding, Obstacles
from kabo.explain.sentences import report
from kabo.explain.unused import Unused
from kabo.given import (
    as_float,
    refuse,
    require_flag,
    require_function,
    require_functions,
    require_given,
    require_number,
    require_procedures,
)
from kabo.knowledge import Verdict as Judged
from kabo.knowledge import ground, verdict_of
from kabo.knowledge.grounding.problem import ground_whole
from kabo.language.problem import Problem
from kabo.options import OPTIONS, ExplainOptions, Options, Search
from kabo.planner.geometry.external_procedures import ExternalProcedures
from kabo.planner.proofs.dead_ends import dead_ends
from kabo.planner.proofs.reasons import beyond_reasoning
from kabo.planner.proofs.unreachable import UnreachableGoal, root_causes_in, unreachable_in
from kabo.planner.proofs.wording import listed
from kabo.planner.result import Progress, Reason
from kabo.planner.search.contingent import find_skeleton
from kabo.planner.search.skeleton import Exhausted, FoundSkeleton, SearchLimits

if TYPE_CHECKING:
    from typing_extensions import Unpack  # Python 3.11 has it itself

SECONDS = 60.0

SHOWN_GAPS = 3  # constructs beyond kabo's reasoning that the summary lists

SPENT = {
    "expansions": "as many nodes as allowed",
    "time": "as long as allowed",
    "memory": "in as much memory as allowed",
}

Planned = Literal["solvable", "proved", "exhausted"]
Verdict = Planned | Literal["invalid"]


@dataclass(frozen=True)
class Explanation:
    """The explanation that `kabo explain` prints.

    `verdict`: `solvable` (there is a plan), `proved` (there is proven to be none), `exhausted` (neither: the
    budget was spent, or the answer would need reasoning by cases), or `invalid` (the files cannot be read).
    `summary`: one to three sentences. `layers`: the number of layers of the delete relaxation. `reachable`:
    whether the last layer contains the whole goal. `findings`: the procedure calls that failed. `counterfactuals`:
    the changes that were tried. `complete`: whether kabo's reasoning about knowledge is complete for this problem;
    if not, "never holds" and "never known" are not proven. `start`: what is wrong with the scene at its start.
    `unfinished`: what there was no time for, as clauses. `problem`: what was explained, for whoever shows the samples
    in its scene.
    """

    verdict: Verdict
    summary: tuple[str, ...]
    reachable: bool = False
    layers: int = 0
    unreachable_goals: tuple[UnreachableGoal, ...] = ()
    unused_actions: tuple[str, ...] = ()
    never_known: tuple[str, ...] = ()
    findings: tuple[Finding, ...] = ()
    counterfactuals: tuple[Counterfactual, ...] = ()
    complete: bool = True
    start: tuple[str, ...] = ()
    unfinished: tuple[str, ...] = ()
    problem: Problem | None = field(default=None, compare=False)

    def __repr__(self) -> str:
        return f"<Explanation {self.verdict}: {shortened(' '.join(self.summary[:1]))}>"

    def _repr_html_(self) -> str:
        figures = {"why": " ".join(self.summary), "at the start": " ".join(self.start)}
        figures |= {goal.text: f"{self.nearest(goal)}: {' '.join(goal.why)}" for goal in self.unreachable_goals}
        figures |= {str(each.call): each.message for each in self.findings}
        figures |= {str(each.change): each.result.replace("_", " ") for each in self.counterfactuals}
        of_no_use = bullets((*self.unused_actions, *self.never_known), "Of no use")
        shown = self if self.findings and self.problem is not None else None
        return display(f"Explanation: {self.verdict}", figures, shown) + of_no_use

    def __str__(self) -> str:
        lines = list(self.summary)
        if self.unreachable_goals:
            never = "never hold" if self.verdict == "proved" else "never hold as far as kabo's knowledge goes"
            lines.append(f"\nParts of the goal that {never}:")
        for goal in self.unreachable_goals:
            lines.append(f"  - {goal.text}, {self.nearest(goal)}:")
            lines += [f"      {sentence}" for sentence in goal.why]
        if self.start:
            lines += ["\nAt the start:", *(f"  - {said}" for said in self.start)]
        lines += report(self.findings, self.counterfactuals)
        so_far = "" if self.complete else ", as far as kabo's knowledge goes"
        for title, sentences in (
            (f"Of no use{so_far}", self.unused_actions),
            (f"Never known{so_far}", self.never_known),
        ):
            if sentences:
                lines += [f"\n{title}:", *(f"  - {sentence}" for sentence in sentences)]
        if self.unfinished:
            lines += ["\nNot finished:", *(f"  - {clause}" for clause in self.unfinished)]
        return "\n".join(lines)

    def nearest(self, goal: UnreachableGoal) -> str:
        """A clause naming the last layer of the delete relaxation that came nearer to an unreachable goal."""
        if not goal.layer:
            return "which nothing brings nearer"
        return f"which nothing brings nearer after layer {goal.layer} of {self.layers}"


def explain(
    problem: Problem,
    *,
    search: Search | None = None,
    max_expansions: int | None = None,
    timeout: float | None = None,
    memory: float | None = None,
    cancelled: Callable[[], bool] | None = None,
    progress: Callable[[Progress], None] | None = None,
    procedures: Mapping[str, Callable[..., Any]] | None = None,
    geometry: bool = True,
    known: Callable[[Explanation], None] = lambda _: None,
    **options: "Unpack[ExplainOptions]",
) -> Explanation:
    """The reasons why a problem has no plan, or that it has one; and the parts of the problem that are useless.

    Args:
        problem: a problem whose names have been checked.
        search: the search algorithm if the relaxation reaches the goal; as for `solve`.
        max_expansions: the greatest number of nodes that the search expands.
        timeout: the number of seconds after which the work ends without an answer.
        memory: bytes that this process may hold before the work ends (None: half of the available memory).
        cancelled: called periodically; True ends the work soon.
        progress: called periodically with the progress of looking for motions.
        procedures: functions that answer the external procedure calls inside formulas, as for `solve`; the
            procedure calls of actions are then assumed to succeed.
        geometry: whether to search for motions as well if the problem has a scene; if not, procedure calls are
            assumed to succeed.
        known: called with the explanation as far as it is known, whenever more is known: for those who may have to
            end this by force.
        options: `kabo.options.ExplainOptions`: `seed`, `epsilon`, `max_samples` and `geometry_order` of
            solving with geometry; `changes`: the greatest number of changes that are tried.

    Raises:
        ArgumentError: an argument is of a wrong kind, or an option takes no such value; says what is expected.
        InputError: the problem uses what the planner does not support, or its initial knowledge
            contradicts itself.

    Example:
        >>> kabo.explain(kabo.load_problem("domains/grid/n3.yaml"))
        <Explanation solvable: There is a plan as far as knowledge goes.>
    """
    require_given("problem", problem, Problem)
    _require_options(search=search, max_expansions=max_expansions, timeout=timeout, memory=memory, **options)
    require_functions(cancelled=cancelled, progress=progress)
    require_procedures(procedures)
    require_function("known", known)
    require_flag("geometry", geometry)
    seconds = SECONDS if timeout is None else as_float(timeout)
    bytes_ = default_memory() if memory is None else memory
    stop = StopFlag(seconds, bytes_, cancelled)
    given = problem
    if procedures:
        problem = ExternalProcedures(problem, procedures, "adaptive").answering()
    whole = ground_whole(problem)
    judged = verdict_of(problem)
    causes = root_causes_in(whole)
    goals = unreachable_in(causes)
    unused = Unused(causes)
    idle, unknown = (*unused.actions(), *unused.rules()), tuple(unused.never_known())
    reached = not goals, whole.reach.layers, tuple(goals), idle, unknown

    def told(found: Obstacles) -> Explanation:
        said = found.verdict, found.summary, *reached, found.findings, found.counterfactuals
        return Explanation(*said, not judged.gaps, found.start, found.unfinished, given)

    if goals:
        unproved = beyond_reasoning(judged)
        verdict: Planned = "proved" if unproved is None else "exhausted"
        summary = _proved(goals) if unproved is None else _unproved(unproved, goals)
    else:
        known(told(Obstacles("exhausted", (SEARCHING,), unfinished=("searching a plan",))))
        expansions = Options.max_expansions if max_expansions is None else max_expansions
        verdict, summary = _searched(problem, judged, search, expansions, stop)
        if verdict == "solvable" and geometry and not procedures and _has_motions(problem):
            # Loads kernels for most of a second, which a problem without a scene never needs.
            from kabo.explain.geometry import obstacles

            left = max(0.0, seconds - (perf_counter() - stop.began))
            asked: dict[str, Any] = {"search": search, "memory": bytes_, "progress": progress}
            asked["known"] = lambda found: known(told(found))
            return told(obstacles(problem, left, cancelled, expansions, **asked, **options))
    return told(Obstacles(verdict, tuple(summary)))


_OWN_OPTIONS = ("search", "max_expansions", "timeout", "memory")  # arguments of `explain` itself


def _require_options(**given: object) -> None:
    """Checks options by the table, and the number of changes, which no other command has.

    Raises:
        ArgumentError: there is no such option, or it takes no such value.
    """
    for name, value in given.items():
        if name not in (known := {*get_type_hints(ExplainOptions), *_OWN_OPTIONS}):
            refuse(name, f"explain() got an unexpected keyword argument {name!r}", did_you_mean(name, known))
        elif name == "changes":
            require_number(name, value, 0, whole=True)
        elif value is not None:
            OPTIONS[name].require(value)


def _has_motions(problem: Problem) -> bool:
    return problem.scene is not None and problem.options.get("geometry") != "none"


def _proved(goals: list[UnreachableGoal]) -> list[str]:
    texts = listed((goal.text for goal in goals), "and")
    return [f"There is no plan, whatever geometry says: {texts} can never hold, whatever is done."]


def _unproved(unproved: Reason, goals: list[UnreachableGoal]) -> list[str]:
    never = f": {listed((goal.text for goal in goals), 'and')} can never be known" if goals else ""
    first = f"No plan was found, {unproved.message}{never}."
    where = "; ".join(unproved.details[:SHOWN_GAPS])
    return [first, f"What kabo does not follow: {where}."]


def _searched(
    problem: Problem, judged: Judged, search: Search | None, expansions: int, stop: StopFlag
) -> tuple[Planned, list[str]]:
    task = ground(problem)
    found = find_skeleton(task, search=search, limits=SearchLimits(expansions, stop))
    if isinstance(found, FoundSkeleton):
        motions = "" if problem.scene is None else "; whether there are motions for it was not asked"
        return "solvable", [f"There is a plan as far as knowledge goes{motions}."]
    if isinstance(found, Exhausted):
        spent = SPENT[stop.spent or found.budget]
        return "exhausted", [
            "Every part of the goal could hold if nothing that is known were ever lost.",
            f"No plan was found in a search that expanded {counted(found.statistics.expanded, 'node')} ({spent}).",
        ]
    unproved = beyond_reasoning(judged)
    if unproved is not None:
        return "exhausted", _unproved(unproved, [])
    return "proved", [NO_PLAN_BUT_REACHABLE, *dead_ends(task, stop)][:3]


SEARCHING = "Every part of the goal could hold if nothing that is known were ever lost; no plan was found so far."
NO_PLAN_BUT_REACHABLE = (
    "There is no plan, whatever geometry says: every part of the goal could hold if nothing that is known were ever "
    "lost, but every way ends in a dead end; all of them have been tried."
)


def explanation_to_json(explanation: Explanation) -> dict[str, Any]:
    """The explanation as a JSON object of the schema `kabo-explain-1`."""
    return {
        "verdict": explanation.verdict,
        **({} if explanation.problem is None else {"problem": str(explanation.problem.path)}),
        "summary": list(explanation.summary),
        "knowledge": {
            "reachable": explanation.reachable,
            "layers": explanation.layers,
            "unreachable_goals": [
                f"{goal.text}, {explanation.nearest(goal)}: {' '.join(goal.why)}"
                for goal in explanation.unreachable_goals
            ],
            "unused_actions": list(explanation.unused_actions),
            "never_known": list(explanation.never_known),
        },
        "start": list(explanation.start),
        "procedures": [_finding_to_json(finding) for finding in explanation.findings],
        "counterfactuals": [each.json() for each in explanation.counterfactuals],
        **({"unfinished": list(explanation.unfinished)} if explanation.unfinished else {}),
    }


def _finding_to_json(finding: Finding) -> dict[str, Any]:
    arguments = [*finding.call.arguments, *(f"{name} = {value}" for name, value in finding.call.options)]
    failures = [asdict(row) | {"between": row.between and list(row.between)} for row in finding.rows]
    return {
        "procedure": finding.call.procedure,
        "arguments": [str(each) for each in arguments],
        "calls": finding.attempts,
        "successes": finding.successes,
        "failures": failures,
        "measures": [asdict(measure) for measure in finding.measures],
        "without": dict(finding.freed),
        "samples": [sample.json() for sample in finding.samples],
        "needed": finding.needed,
        "repeated": finding.repeated,
    }


def invalid_explanation(error: InputError) -> Explanation:
    """The explanation of a problem that cannot be read."""
    found = error.diagnostics
    first = found[0]
    return Explanation(
        "invalid",
        (
            f"The problem cannot be read: {counted(len(found), 'finding')}.",
            f"The first is in {first.file}, line {first.line}: {first.message}.",
        ),
    )
