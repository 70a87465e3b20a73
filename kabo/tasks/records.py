"""Records of calls: how often each succeeded and failed, and where it failed, so that it can be asked there again."""

from dataclasses import dataclass, field

from kabo.geometry_server import Answer, Refusal, Situation
from kabo.language.formulas import GroundCall

FORESEEN = -1  # the effort of what was told before any search, without a sample
PLACES = 3  # where a call failed: as many are kept, the first ones of the greatest effort


@dataclass(frozen=True)
class Where:
    """A situation in which a call failed, from which attempt on, and the effort that was made."""

    situation: Situation
    attempt: int
    effort: int
    refusal: Refusal


@dataclass
class Record:
    """What came of all the times that one call was made."""

    successes: int = 0
    failures: int = 0
    places: list[Where] = field(default_factory=list)

    def note(self, situation: Situation, attempt: int, effort: int, answer: Answer) -> None:
        """One answer; of a call that had other answers before it, a failure is told only if there are no others."""
        if not isinstance(answer, Refusal):
            self.successes += 1
            return
        self.failures += 1
        rank = (attempt == 0, effort)
        kept = self.places and (self.places[0].attempt == 0, self.places[0].effort)
        if kept and rank > kept:
            self.places.clear()
        if not kept or rank >= kept:
            self.places = [*self.places, Where(situation, attempt, effort, answer)][:PLACES]


@dataclass
class Records:
    """The records of all calls, in order of their first answer."""

    of: dict[GroundCall, Record] = field(default_factory=dict)

    def note(self, call: GroundCall, situation: Situation, attempt: int, effort: int, answer: Answer) -> None:
        """One answer to a call."""
        self.of.setdefault(call, Record()).note(situation, attempt, effort, answer)
