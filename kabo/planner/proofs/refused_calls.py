"""Refused calls of procedures in short: what was refused, and what blocked it most often."""

from collections import Counter
from collections.abc import Iterable

from kabo.geometry_server.answers import Failure, Pair
from kabo.language.formulas import GroundCall
from kabo.planner.proofs.wording import counted


def blocking_pairs(call: GroundCall, counts: Iterable[tuple[Pair, int]]) -> list[tuple[str, int]]:
    """Of pairs with counts those things that a call does not name itself, the most frequent first."""
    arguments = {str(value) for value in call.arguments}
    found = Counter[str]()
    for pair, count in counts:
        owners = [name.partition(".")[0] for name in pair]
        others = [name for name in owners if name not in arguments] or owners[-1:]
        for name in dict.fromkeys(others):
            found[name] += count
    return sorted(found.items(), key=lambda item: (-item[1], item[0]))


def refused(call: GroundCall, failure: Failure) -> str:
    """A refusal in short, from what was counted while solving: `pick(left, cup): blocked by lid in 40 of 64 attempts`."""
    body, count = next(iter(blocking_pairs(call, failure.between)), (None, 0))
    if body is None or failure.reason not in ("collision", "no_path"):
        return f"{call}: {failure.message.partition(': ')[2] or failure.message}"
    if count <= failure.attempts:
        return f"{call}: blocked by {body} in {count} of {counted(failure.attempts, 'attempt')}"
    return f"{call}: {failure.reason.replace('_', ' ')}, blocked by {body} most often"
