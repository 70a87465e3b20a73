"""Why a robot stage refuses: the pairs of things that came too close, what was read, and the question behind it."""

from dataclasses import dataclass

from kabo.geometry_server import Pair
from kabo.tasks.core import Failure
from kabo.tasks.robots.motion.questions import MotionQuestion


@dataclass(frozen=True)
class Details:
    """What a failure is about, for programs: pairs that came too close, with counts; proofs; what was read and asked."""

    pairs: tuple[tuple[Pair, int], ...] = ()
    reads: frozenset[str] = frozenset()
    proof: bool = False
    missing: float | None = None
    question: MotionQuestion | None = None


def refusal(
    reason: str,
    comment: str = "",
    *,
    pairs: tuple[tuple[Pair, int], ...] = (),
    hit: Pair | None = None,
    reads: frozenset[str] = frozenset(),
    proof: bool = False,
    missing: float | None = None,
    question: MotionQuestion | None = None,
) -> Failure:
    """A failure with its details; `hit` is the one pair that was in the way."""
    if hit is not None:
        pairs = ((hit, 1),)
    if not comment and pairs:
        comment = f"{pairs[0][0][0]} – {pairs[0][0][1]}"
    return Failure(reason, comment, Details(pairs, reads, proof, missing, question))
