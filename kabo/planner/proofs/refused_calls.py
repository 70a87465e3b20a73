"""Refused calls as short sentences: what was refused, and what blocked it most often."""

from collections import Counter
from collections.abc import Iterable

from kabo.displays import counted
from kabo.geometry_server.answers import BLOCKED_REASONS, Pair, Refusal, owners, pair_text
from kabo.geometry_server.foresight.measures import Measure
from kabo.language.formulas import GroundCall


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


def own_pair(body: str, pairs: Iterable[tuple[Pair, int]]) -> Pair | None:
    """The first pair of links that both belong to `body`: a robot that is in its own way; None if there is none."""
    return next((pair for pair, _ in pairs if owners(pair) == (body, body)), None)


def own_text(pair: Pair, measures: Iterable[Measure]) -> str:
    """The pair of links of a robot that is in its own way, with how near they come if that was measured."""
    name = pair_text(pair)
    return next((measure.text for measure in measures if measure.name == name), f"{pair[0]} and {pair[1]}")


def most_refused(failures: Iterable[tuple[GroundCall, Refusal]]) -> str:
    """The call that was refused most, such as `pick(left, cup) refused 1,064 times, mostly by lid`; empty if none was."""
    call, refusal = max(failures, key=lambda item: item[1].attempts, default=(None, None))
    if call is None or refusal is None or refusal.attempts < 1:
        return ""
    said = f"{call} refused {refusal.attempts:,} time{'' if refusal.attempts == 1 else 's'}"
    body, count = next(iter(blocking_pairs(call, refusal.pairs)), (None, 0))
    if body is None:
        return said
    itself = " itself" if own_pair(body, refusal.pairs) else ""
    return f"{said}, {'mostly' if 2 * count > refusal.attempts else 'most often'} by {body}{itself}"


def refused(call: GroundCall, refusal: Refusal) -> str:
    """A refusal as a short sentence, such as `pick(left, cup): blocked by lid in 40 of 64 attempts`, with its numbers."""
    said = _said(call, refusal)
    return "; ".join((said, *(each.text for each in refusal.measures if each.said not in said)))


def _said(call: GroundCall, refusal: Refusal) -> str:
    body, count = next(iter(blocking_pairs(call, refusal.pairs)), (None, 0))
    if body is None or refusal.reason not in BLOCKED_REASONS:
        return f"{call}: {refusal.comment.partition(': ')[2] or refusal.comment}"
    if refusal.reason == "hidden":
        return f"{call}: hidden by {body} most often"
    own = own_pair(body, refusal.pairs)
    if own is not None:
        share = f" in {count} of {counted(refusal.attempts, 'attempt')}" if count <= refusal.attempts else ""
        return f"{call}: blocked by {body} itself{share}, most often {own_text(own, refusal.measures)}"
    if count <= refusal.attempts:
        return f"{call}: blocked by {body} in {count} of {counted(refusal.attempts, 'attempt')}"
    return f"{call}: {refusal.reason.replace('_', ' ')}, blocked by {body} most often"
