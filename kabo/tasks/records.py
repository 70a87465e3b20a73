"""Statistics of calls: how often each succeeded and failed, and in which situations, for explanations."""

from dataclasses import dataclass, field

from kabo.geometry_server import Answer, Refusal, Situation
from kabo.language.formulas import GroundCall

FORESEEN = -1  # effort of a failure that was known before any search, without sampling
MAX_KEPT_SITUATIONS = 3  # situations kept in which a call failed: the first ones with the greatest effort


@dataclass(frozen=True)
class Where:
    """A failure of a call: the situation, the attempt, the effort and the refusal."""

    situation: Situation
    attempt: int
    effort: int
    refusal: Refusal


@dataclass
class Record:
    """The answers to one call: their numbers, and the situations in which it failed."""

    successes: int = 0
    failures: int = 0
    places: list[Where] = field(default_factory=list)

    def note(self, situation: Situation, attempt: int, effort: int, answer: Answer) -> None:
        """Counts an answer, and keeps the situations of the most telling failures.

        Failures of a first attempt displace those after earlier solutions; then higher effort displaces lower.
        """
        if not isinstance(answer, Refusal):
            self.successes += 1
            return
        self.failures += 1
        rank = (attempt == 0, effort)
        kept = self.places and (self.places[0].attempt == 0, self.places[0].effort)
        if kept and rank > kept:
            self.places.clear()
        if not kept or rank >= kept:
            self.places = [*self.places, Where(situation, attempt, effort, answer)][:MAX_KEPT_SITUATIONS]


@dataclass
class Records:
    """The records of all calls, in order of their first answer."""

    of: dict[GroundCall, Record] = field(default_factory=dict)
    unfinished: dict[GroundCall, Where] = field(default_factory=dict)  # cut off: what was refused until then

    def note(self, call: GroundCall, situation: Situation, attempt: int, effort: int, answer: Answer) -> None:
        """Counts an answer to a call in the call's record."""
        self.of.setdefault(call, Record()).note(situation, attempt, effort, answer)
