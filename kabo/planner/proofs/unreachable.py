"""Finds the goal conjuncts that can never hold, even under delete relaxation, and explains why in sentences."""

from collections.abc import Iterator, Set
from dataclasses import dataclass

from kabo.knowledge.grounding.problem import Grounding, conjuncts, ground_whole
from kabo.knowledge.queries import FALSE
from kabo.language.problem import Problem
from kabo.planner.proofs.achievers import Achievers
from kabo.planner.proofs.mentions import Mentions
from kabo.planner.proofs.root_causes import RootCauses
from kabo.planner.proofs.static_false import why_false
from kabo.planner.proofs.wording import BitMeanings

SAME_REASONS = "For the same reasons as"  # begins the sentence about a conjunct that another one explains


@dataclass(frozen=True)
class UnreachableGoal:
    """A conjunct of the goal that can never hold, and why.

    `layer`: the last layer of the delete relaxation in which something that the conjunct needs became possible.
    """

    text: str
    layer: int
    why: tuple[str, ...]


def unreachable_because(problem: Problem) -> list[UnreachableGoal]:
    """The conjuncts of the goal that can never hold, each with the sentences that say why."""
    return unreachable_in(root_causes_in(ground_whole(problem)))


def root_causes_in(whole: Grounding) -> RootCauses:
    """The object that explains root causes in a grounded problem."""
    meanings = BitMeanings(whole)
    return RootCauses(Achievers(whole, meanings), meanings, Mentions(whole))


def unreachable_in(causes: RootCauses) -> list[UnreachableGoal]:
    """The goal conjuncts that the delete relaxation never reaches, each with sentences that say why."""
    whole = causes.achievers.whole
    compiler, reach = whole.compiler, whole.reach
    first_with: dict[tuple[object, ...], str] = {}
    found: list[UnreachableGoal] = []
    texts = {part.text for part in whole.goal}
    for part, (formula, binding) in zip(whole.goal, conjuncts(compiler, compiler.problem.goal, {}), strict=True):
        if part.query == FALSE:
            why = tuple(why_false(compiler, formula, binding))
            found.append(UnreachableGoal(part.text, 0, why))
        elif not part.query.possible(reach.ones, reach.zeros):
            reasons = causes.reasons(part.query)
            kinds = tuple(case.kinds for case in reasons.cases)
            same = first_with.setdefault(kinds, part.text)
            why = tuple(causes.sentences(reasons))
            if same != part.text:
                why = (f"{SAME_REASONS} {same}.",)
            why = (*_contradiction(part.text, texts), *why)
            found.append(UnreachableGoal(part.text, reasons.layer, why))
    return found


def _contradiction(text: str, texts: Set[str]) -> Iterator[str]:
    """A sentence if another conjunct of the goal asks for the opposite of K(not fact)."""
    opposite = text.replace("K(not ", "K(", 1)
    if opposite != text and opposite in texts:
        yield f"The goal contradicts itself: it asks for {opposite} as well."
