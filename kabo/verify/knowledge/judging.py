"""Who judges what a plan knows: all possible worlds; and where these cannot, the replay of kabo's own inference."""

from collections.abc import Sequence
from dataclasses import dataclass

from kabo.language.problem import Problem
from kabo.plan import Plan
from kabo.verify.knowledge.arguments import check_calls
from kabo.verify.knowledge.replay import replay
from kabo.verify.knowledge.worlds import CannotJudgeError, judge_in_worlds
from kabo.verify.knowledge.worlds.world import MOST_VALUES
from kabo.verify.report import Finding, WorldReport
from kabo.verify.structure import check_structure


@dataclass(frozen=True)
class KnowledgeReport:
    """What is wrong with a plan's knowledge, and who says so.

    Attributes:
        findings: what is wrong.
        states: how many states of knowledge were looked at.
        worlds: what the run through all worlds came to; None if worlds could not judge.
        why_replay: why not; None if they could.
    """

    findings: tuple[Finding, ...]
    states: int = 0
    worlds: WorldReport | None = None
    why_replay: str | None = None


def check_knowledge(
    problem: Problem, plan: Plan, order: Sequence[str], *, limit: int = MOST_VALUES
) -> KnowledgeReport:
    """Judges a plan whose reached nodes are given, each before its successors."""
    wrong = tuple(check_calls(plan, order, problem))
    if wrong:
        return KnowledgeReport(wrong)
    try:
        judged = judge_in_worlds(problem, plan, order, limit=limit)
        return KnowledgeReport(judged.report.findings, judged.states, judged.report)
    except CannotJudgeError as error:
        played = replay(plan, problem, order)
        return KnowledgeReport(tuple(played.findings), played.states, None, str(error))


def validate_worlds(problem: Problem, plan: Plan, *, limit: int = MOST_VALUES) -> WorldReport:
    """Leads a plan through all worlds that the initial knowledge allows.

    Args:
        problem: the problem.
        plan: the plan.
        limit: how many values of atoms and terms, in all worlds that are made, before it is given up.

    Returns:
        What was found; `exhaustive` is False, with the reason as a finding, if worlds cannot judge the plan.
    """
    order, findings = check_structure(plan)
    findings.extend(check_calls(plan, order, problem))
    if findings or not order:
        return WorldReport(tuple(findings), exhaustive=False)
    try:
        return judge_in_worlds(problem, plan, order, limit=limit).report
    except CannotJudgeError as error:
        return WorldReport((Finding(None, f"worlds cannot judge this plan: {error}"),), exhaustive=False)
