"""Judges a plan's knowledge in all possible worlds or, if that is impossible, by replaying kabo's inference."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from kabo.language.problem import Problem
from kabo.plan import Plan
from kabo.verify.knowledge.arguments import check_calls
from kabo.verify.knowledge.past import with_past
from kabo.verify.knowledge.replay import replay
from kabo.verify.knowledge.worlds import CannotJudgeError, judge_in_worlds
from kabo.verify.knowledge.worlds.world import MAX_VALUES
from kabo.verify.report import Finding, WorldReport
from kabo.verify.structure import check_structure


@dataclass(frozen=True)
class KnowledgeReport:
    """The faults of a plan's knowledge, and how they were judged.

    Attributes:
        findings: the faults.
        states: the number of examined states of knowledge.
        worlds: the report of the run through all worlds; None if worlds could not judge the plan.
        why_replay: why worlds could not judge the plan; None if they could.
    """

    findings: tuple[Finding, ...]
    states: int = 0
    worlds: WorldReport | None = None
    why_replay: str | None = None


def check_knowledge(
    problem: Problem, plan: Plan, order: Sequence[str], *, limit: int = MAX_VALUES
) -> KnowledgeReport:
    """Checks the knowledge on every branch of a plan; `order` lists the reached nodes in topological order."""
    wrong = tuple(_events(plan, order, problem))
    problem, (plan, order) = problem.with_events() if plan.done else problem, with_past(plan, order)
    wrong = (*wrong, *check_calls(plan, order, problem))
    if wrong:
        return KnowledgeReport(wrong)
    try:
        judged = judge_in_worlds(problem, plan, order, limit=limit)
        return KnowledgeReport(judged.report.findings, judged.states, judged.report)
    except CannotJudgeError as error:
        played = replay(plan, problem, order)
        return KnowledgeReport(tuple(played.findings), played.states, None, str(error))


def validate_worlds(problem: Problem, plan: Plan, *, limit: int = MAX_VALUES) -> WorldReport:
    """Follows a plan through all worlds that the initial knowledge allows.

    Args:
        problem: the problem.
        plan: the plan.
        limit: the largest permitted number of values of atoms and terms, summed over all worlds that are created.

    Returns:
        the report; `exhaustive` is False, with the reason as a finding, if worlds cannot judge the plan.
    """
    order, findings = check_structure(plan)
    findings.extend(_events(plan, order, problem))
    problem, (plan, order) = problem.with_events() if plan.done else problem, with_past(plan, order)
    findings.extend(check_calls(plan, order, problem))
    if findings or not order:
        return WorldReport(tuple(findings), exhaustive=False)
    try:
        return judge_in_worlds(problem, plan, order, limit=limit).report
    except CannotJudgeError as error:
        return WorldReport((Finding(None, f"worlds cannot judge this plan: {error}"),), exhaustive=False)


def _events(plan: Plan, order: Sequence[str], problem: Problem) -> Iterator[Finding]:
    """The findings about nodes that would do what only happens."""
    for name in order:
        if plan.nodes[name].action in problem.domain.events:
            yield Finding(name, f'"{plan.nodes[name].action}" is an event: it happens, and nobody does it')
