"""Explains why a fact can never be known: its achievers, and the facts that block each, down to root causes.

Of everything that blocks an achiever, only the fact nearest to a root cause is reported. Similar facts are
reported once: facts of the same symbol, with the same kinds of achievers, blocked by the same kinds of facts, form
one group.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

from kabo.displays import counted
from kabo.knowledge import Query
from kabo.knowledge.facts import AtomBits, ConjunctionBits, TermBits
from kabo.knowledge.queries import All, AllOf, bits_of
from kabo.planner.proofs.achievers import Achiever, Achievers
from kabo.planner.proofs.mentions import Mentions
from kabo.planner.proofs.wording import BitMeanings, Meaning, MissingFact, listed, missing_facts

MAX_FACTS = 20_000  # missing facts that one explanation follows
MAX_SENTENCES = 8  # sentences of one explanation, beside those of root causes
MAX_WAYS = 4  # achievers that one sentence lists

_BY = {"does": "", "senses": "sensing by ", "rule": "", "entry": "knowing "}

Kind = tuple[str, str, bool]  # symbol, role, whether it is asked to be set


@dataclass
class CauseGroup:
    """A group of similar missing facts, in order of discovery, and the achievers of the first fact."""

    members: list[MissingFact]
    achievers: list[Achiever]
    kinds: tuple[object, ...]


@dataclass
class Reasons:
    """The missing facts and other causes that prevent a query from ever holding.

    `circular`: facts that are blocked only by each other. `layer`: the last layer of the delete relaxation in
    which something that the achievers need became possible.
    """

    cases: list[CauseGroup] = field(default_factory=list)
    circular: list[MissingFact] = field(default_factory=list)
    layer: int = 0


class RootCauses:
    """Explains why the delete relaxation cannot reach a fact."""

    def __init__(self, achievers: Achievers, meanings: BitMeanings, mentions: Mentions) -> None:
        self.achievers, self.meanings, self.mentions = achievers, meanings, mentions
        self.reach, self._initial = achievers.whole.reach, achievers.whole.initial
        self._achievers: dict[MissingFact, list[Achiever]] = {}
        self._rank: dict[MissingFact, int] = {}  # distance of a fact from its root causes; circular ones have none

    def reasons(self, query: Query) -> Reasons:
        """The reasons why an impossible query can never hold; the facts that the query itself lacks come first."""
        first = list(dict.fromkeys(missing_facts(query, self.achievers.ones, self.achievers.zeros)))
        self._rank_all(first)
        queue, seen, reads = list(first), set(first), query.reads
        cases: dict[tuple[object, ...], CauseGroup] = {}
        for fact in queue:  # grows while it is worked on
            achievers = self._achievers.get(fact, [])
            lacking = [self.lacking(achiever.blocker) for achiever in achievers]
            pairs = zip(achievers, lacking, strict=True)
            ways = {(achiever.kind, achiever.family, self._kinds(lack)) for achiever, (_, lack) in pairs}
            kinds = (*self._kind(fact), tuple(sorted(ways)))
            cases.setdefault(kinds, CauseGroup([], achievers, kinds)).members.append(fact)
            for achiever, (_, lack) in zip(achievers, lacking, strict=True):
                reads |= achiever.blocker.reads
                queue += [other for other in lack if other not in seen]
                seen.update(lack)
        return Reasons(list(cases.values()), self._circular(queue), self._layer(reads))

    def lacking(self, blocker: Query) -> tuple[str, list[MissingFact]]:
        """The facts missing for a query, as text and as a list.

        If the query contains a conjunction that can never hold, only the fact nearest to a root cause is included.
        """
        parts = blocker.parts if isinstance(blocker, All) else (blocker,)
        for part in parts:
            if isinstance(part, AllOf) and not part.possible(self.achievers.ones, self.achievers.zeros):
                found = list(missing_facts(part, self.achievers.ones, self.achievers.zeros))
                fact = min(found, key=lambda fact: self._rank.get(fact, MAX_FACTS))
                return self.meanings.text(fact), [fact]
        found = list(dict.fromkeys(missing_facts(blocker, self.achievers.ones, self.achievers.zeros)))
        return self.meanings.query(blocker, self.achievers.ones, self.achievers.zeros), found

    def kind_of_lack(self, blocker: Query) -> tuple[Kind, ...]:
        """The kinds of the facts that are missing for a query."""
        self._rank_all(missing_facts(blocker, self.achievers.ones, self.achievers.zeros))
        return self._kinds(self.lacking(blocker)[1])

    def sentences(self, reasons: Reasons) -> list[str]:
        """The reasons as sentences; long lists are shortened, but include the root causes."""
        roots = [case for case in reasons.cases if not case.achievers][:MAX_SENTENCES]
        first = reasons.cases[:MAX_SENTENCES]
        shown = [case for case in reasons.cases if case in first or case in roots]
        sentences = [self._sentence(case) for case in shown]
        more = len(reasons.cases) - len(shown)
        if more:
            sentences.append(
                f"{counted(more, 'further step')} between these {'is' if more == 1 else 'are'} left out."
            )
        texts = [self.meanings.text(fact) for fact in reasons.circular]
        if len(texts) == 1:
            sentences.append(f"So {texts[0]} waits for itself, and it does not hold at the start.")
        elif texts:
            sentences.append(
                f"So {listed(texts, 'and')} wait for each other, and none of them holds at the start."
            )
        return sentences

    def _rank_all(self, first: Iterable[MissingFact]) -> None:
        """Finds the achievers of these facts, and of all that they need, and how far each fact is from its root causes."""
        queue = [fact for fact in dict.fromkeys(first) if fact not in self._achievers]
        waiting: dict[MissingFact, list[list[MissingFact]]] = {}
        for fact in queue:  # grows while it is worked on
            if fact in self._achievers or len(waiting) >= MAX_FACTS:
                continue
            self._achievers[fact] = self.achievers.of(fact)
            waiting[fact] = [self.achievers.missing_facts(achiever) for achiever in self._achievers[fact]]
            queue += [other for blockers in waiting[fact] for other in blockers if other not in self._achievers]
        rank = 0
        while True:
            found = [
                fact
                for fact, achievers in waiting.items()
                if all(any(o in self._rank for o in m) for m in achievers)
            ]
            if not found:
                return
            for fact in found:
                self._rank[fact] = rank
                del waiting[fact]
            rank += 1

    def _circular(self, queue: list[MissingFact]) -> list[MissingFact]:
        """The facts without a root cause, but for those that no other of them needs."""
        found = [fact for fact in queue if fact not in self._rank and fact in self._achievers]
        while True:
            needed = {
                o
                for fact in found
                for achiever in self._achievers[fact]
                for o in self.lacking(achiever.blocker)[1]
            }
            left = [fact for fact in found if fact in needed]
            if left == found:
                return found
            found = left

    def _kind(self, fact: MissingFact) -> Kind:
        meaning = self.meanings.meaning(fact.bit)
        return meaning.symbol, meaning.role, fact.is_set

    def _kinds(self, found: Iterable[MissingFact]) -> tuple[Kind, ...]:
        return tuple(sorted({self._kind(fact) for fact in found}))

    def _layer(self, reads: int) -> int:
        """The last layer in which one of the bits became possible."""
        history = self.reach.history
        new = (after[0] & ~before[0] & reads for before, after in zip(history, history[1:], strict=False))
        return max((number for number, bits in enumerate(new, start=1) if bits), default=0)

    # ---------------------------------------------------------------------------------------------- sentences
    def _sentence(self, case: CauseGroup) -> str:
        first, *others = case.members
        sentences = self._ways(first, case) if case.achievers else self.nothing(first)
        if others:
            sentences += f" Likewise {listed([self.meanings.text(fact) for fact in others], 'and')}."
        return sentences

    def _ways(self, fact: MissingFact, case: CauseGroup) -> str:
        """A sentence with the achievers of a fact, each with what it lacks."""
        families: dict[tuple[str, str, tuple[Kind, ...]], list[Achiever]] = {}
        for achiever in case.achievers:
            lack = self._kinds(self.lacking(achiever.blocker)[1])
            families.setdefault((achiever.kind, achiever.family, lack), []).append(achiever)
        ways = [self._way(achievers) for achievers in families.values()]
        never = ", and that never holds" if len(ways) == 1 else ": none of that ever holds"
        if fact.is_set:
            said = f"{self.meanings.text(fact)} can only come from "
        else:
            said = f"{self.meanings.meaning(fact.bit).text} holds from the start and can only be lost by "
        return f"{said}{'; or from '.join(ways[:MAX_WAYS])}{_rest(ways)}{never}."

    def _way(self, achievers: list[Achiever]) -> str:
        first = achievers[0]
        more = f" (and {len(achievers) - 1} more like it)" if len(achievers) > 1 else ""
        return f"{_BY[first.kind]}{first.name}{more}, which needs {self.lacking(first.blocker)[0]}"

    def nothing(self, fact: MissingFact) -> str:
        """The sentence that says that a fact has no achievers, and why."""
        meaning = self.meanings.meaning(fact.bit)
        if not fact.is_set:
            return f"{meaning.text} holds from the start, and nothing ever takes that away."
        match meaning.role:
            case "always":
                return f"{meaning.about} does not hold at the start already."
            case "entry":
                return f"Nothing tells {meaning.about}."
            case "true" | "false" | "equal" | "unequal":
                said = f"Nothing makes {meaning.text}"
            case "whether" if isinstance(meaning.group, AtomBits | ConjunctionBits):
                said = f"{meaning.about} can never be known whether"
            case _:
                said = f"The value of {meaning.about} can never be known"
        return f"{said}: {self.why_nothing(meaning)}."

    def why_nothing(self, meaning: Meaning) -> str:
        """The reason why no initial fact, action or rule makes a fact known, as a clause that ends a sentence."""
        return f"{self._at_the_start(meaning)}, {self.mentions.why_no_achiever(meaning)}"

    def _at_the_start(self, meaning: Meaning) -> str:
        group = meaning.group
        if isinstance(group, TermBits | AtomBits):
            for bit in bits_of(self._initial & group.known):
                return f"{self.meanings.meaning(bit).text} holds at the start"
        return "it is not known at the start"


def _rest(ways: list[str]) -> str:
    return f"; or from {counted(len(ways) - MAX_WAYS, 'other way')}" if len(ways) > MAX_WAYS else ""
