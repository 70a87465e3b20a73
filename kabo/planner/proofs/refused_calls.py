"""Refused calls as short sentences: what was refused, and what blocked it most often."""

from collections import Counter
from collections.abc import Iterable

from kabo.geometry_server.answers import BLOCKED_REASONS, Pair, Refusal, owners
from kabo.language.formulas import GroundCall
from kabo.planner.proofs.wording import counted


def blocking_pairs(call: GroundCall, counts: Iterable[tuple[Pair, int]]) -> list[tuple[str, int]]:
    """The bodies and robots in pairs, with counts, most frequent first; those that the call names are left out."""
    arguments = {str(value) for value in call.arguments}
    found = Counter[str]()
    for pair, count in counts:
        things = owners(pair)
        others = [name for name in things if name not in arguments] or things[-1:]
        for name in dict.fromkeys(others):
            found[name] += count
    return sorted(found.items(), key=lambda item: (-item[1], item[0]))


def refused(call: GroundCall, refusal: Refusal) -> str:
    """A refusal as a short sentence, such as `pick(left, cup): blocked by lid in 40 of 64 attempts`, with its numbers."""
    return "; ".join((_said(call, refusal), *_untold(refusal)))


def _untold(refusal: Refusal) -> list[str]:
    """The numbers of a refusal that its sentence does not tell."""
    is_told = refusal.reason not in BLOCKED_REASONS or not refusal.pairs
    return [each.text for each in refusal.measures if not (is_told and each.said in refusal.comment)]


def _said(call: GroundCall, refusal: Refusal) -> str:
    body, count = next(iter(blocking_pairs(call, refusal.pairs)), (None, 0))
    if body is None or refusal.reason not in BLOCKED_REASONS:
        return f"{call}: {refusal.comment.partition(': ')[2] or refusal.comment}"
    if refusal.reason == "hidden":
        return f"{call}: hidden by {body} most often"
    if count <= refusal.attempts:
        return f"{call}: blocked by {body} in {count} of {counted(refusal.attempts, 'attempt')}"
    return f"{call}: {refusal.reason.replace('_', ' ')}, blocked by {body} most often"
