"""Why something can never be known, down to the root cause: what could make it, and what keeps that from happening.

Of all that keeps a maker from acting, one want is told: the one that is nearest to a root cause. What is alike is
told once: wants of the same symbol with the same kinds of makers, blocked by the same kinds of wants, are one *case*.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

from kabo.knowledge import Query
from kabo.knowledge.facts import AtomBits, ConjunctionBits, TermBits
from kabo.knowledge.queries import All, AllOf, bits_of
from kabo.planner.proofs.achievers import Maker, Makers
from kabo.planner.proofs.mentions import Origins
from kabo.planner.proofs.wording import Meaning, Want, Words, counted, listed, wants

MAX_WANTS = 20_000  # looked at for one explanation
MAX_SENTENCES = 8
MAX_WAYS = 4

_BY = {"does": "", "senses": "sensing by ", "rule": "", "entry": "knowing "}

Kind = tuple[str, str, bool]  # symbol, role, whether it is asked to be set


@dataclass
class Case:
    """Like wants, the one met first at the front, and what could make that."""

    members: list[Want]
    makers: list[Maker]
    kinds: tuple[object, ...]


@dataclass
class Reasons:
    """Everything that keeps a query from ever holding.

    `circular` wants wait for each other and for nothing else; `layer` is the last one in which something became
    possible that the makers need.
    """

    cases: list[Case] = field(default_factory=list)
    circular: list[Want] = field(default_factory=list)
    layer: int = 0


class Blocked:
    """Explains wants that the delete relaxation cannot reach."""

    def __init__(self, makers: Makers, words: Words, origins: Origins) -> None:
        self.makers, self.words, self.origins = makers, words, origins
        self.reach, self._initial = makers.whole.reach, makers.whole.initial
        self._makers: dict[Want, list[Maker]] = {}
        self._rank: dict[Want, int] = {}  # how many steps a want is from its root causes; circular ones have none

    def reasons(self, query: Query) -> Reasons:
        """What keeps an impossible query from ever holding, nearest causes first."""
        first = list(dict.fromkeys(wants(query, self.makers.ones, self.makers.zeros)))
        self._rank_all(first)
        queue, seen, reads = list(first), set(first), query.reads
        cases: dict[tuple[object, ...], Case] = {}
        for want in queue:  # grows while it is worked on
            makers = self._makers.get(want, [])
            lacking = [self.lacking(maker.blocker) for maker in makers]
            pairs = zip(makers, lacking, strict=True)
            ways = {(maker.kind, maker.family, self._kinds(lack)) for maker, (_, lack) in pairs}
            kinds = (*self._kind(want), tuple(sorted(ways)))
            cases.setdefault(kinds, Case([], makers, kinds)).members.append(want)
            for maker, (_, lack) in zip(makers, lacking, strict=True):
                reads |= maker.blocker.reads
                queue += [other for other in lack if other not in seen]
                seen.update(lack)
        return Reasons(list(cases.values()), self._circular(queue), self._layer(reads))

    def lacking(self, blocker: Query) -> tuple[str, list[Want]]:
        """What a blocked query is told to lack: of a conjunction the want nearest to a root cause."""
        parts = blocker.parts if isinstance(blocker, All) else (blocker,)
        for part in parts:
            if isinstance(part, AllOf) and not part.possible(self.makers.ones, self.makers.zeros):
                found = list(wants(part, self.makers.ones, self.makers.zeros))
                want = min(found, key=lambda want: self._rank.get(want, MAX_WANTS))
                return self.words.text(want), [want]
        found = list(dict.fromkeys(wants(blocker, self.makers.ones, self.makers.zeros)))
        return self.words.query(blocker, self.makers.ones, self.makers.zeros), found

    def kind_of_lack(self, blocker: Query) -> tuple[Kind, ...]:
        """The kinds of what a blocked query is told to lack; its causes are looked up."""
        self._rank_all(wants(blocker, self.makers.ones, self.makers.zeros))
        return self._kinds(self.lacking(blocker)[1])

    def sentences(self, reasons: Reasons) -> list[str]:
        """The reasons for people; root causes are never left out."""
        roots = [case for case in reasons.cases if not case.makers][:MAX_SENTENCES]
        first = reasons.cases[:MAX_SENTENCES]
        shown = [case for case in reasons.cases if case in first or case in roots]
        told = [self._sentence(case) for case in shown]
        more = len(reasons.cases) - len(shown)
        if more:
            told.append(f"{counted(more, 'further step')} between these {'is' if more == 1 else 'are'} left out.")
        texts = [self.words.text(want) for want in reasons.circular]
        if len(texts) == 1:
            told.append(f"So {texts[0]} waits for itself, and it does not hold at the start.")
        elif texts:
            told.append(f"So {listed(texts, 'and')} wait for each other, and none of them holds at the start.")
        return told

    def _rank_all(self, first: Iterable[Want]) -> None:
        """Looks up all that could make these wants, and how far each is from its root causes."""
        queue = [want for want in dict.fromkeys(first) if want not in self._makers]
        waiting: dict[Want, list[list[Want]]] = {}
        for want in queue:  # grows while it is worked on
            if want in self._makers or len(waiting) >= MAX_WANTS:
                continue
            self._makers[want] = self.makers.of(want)
            waiting[want] = [self.makers.wants(maker) for maker in self._makers[want]]
            queue += [other for blockers in waiting[want] for other in blockers if other not in self._makers]
        rank = 0
        while True:
            found = [
                want for want, makers in waiting.items() if all(any(o in self._rank for o in m) for m in makers)
            ]
            if not found:
                return
            for want in found:
                self._rank[want] = rank
                del waiting[want]
            rank += 1

    def _circular(self, queue: list[Want]) -> list[Want]:
        """The wants without root cause; those that no other of them needs left out."""
        found = [want for want in queue if want not in self._rank and want in self._makers]
        while True:
            needed = {o for want in found for maker in self._makers[want] for o in self.lacking(maker.blocker)[1]}
            left = [want for want in found if want in needed]
            if left == found:
                return found
            found = left

    def _kind(self, want: Want) -> Kind:
        meaning = self.words.meaning(want.bit)
        return meaning.symbol, meaning.role, want.is_set

    def _kinds(self, found: Iterable[Want]) -> tuple[Kind, ...]:
        return tuple(sorted({self._kind(want) for want in found}))

    def _layer(self, reads: int) -> int:
        """The last layer in which one of the bits became possible."""
        history = self.reach.history
        new = (after[0] & ~before[0] & reads for before, after in zip(history, history[1:], strict=False))
        return max((number for number, bits in enumerate(new, start=1) if bits), default=0)

    # ---------------------------------------------------------------------------------------------- sentences
    def _sentence(self, case: Case) -> str:
        first, *others = case.members
        told = self._ways(first, case) if case.makers else self.nothing(first)
        if others:
            told += f" Likewise {listed([self.words.text(want) for want in others], 'and')}."
        return told

    def _ways(self, want: Want, case: Case) -> str:
        """What could make the want, each with what it lacks."""
        families: dict[tuple[str, str, tuple[Kind, ...]], list[Maker]] = {}
        for maker in case.makers:
            lack = self._kinds(self.lacking(maker.blocker)[1])
            families.setdefault((maker.kind, maker.family, lack), []).append(maker)
        ways = [self._way(makers) for makers in families.values()]
        never = ", and that never holds" if len(ways) == 1 else ": none of that ever holds"
        if want.is_set:
            said = f"{self.words.text(want)} can only come from "
        else:
            said = f"{self.words.meaning(want.bit).text} holds from the start and can only be lost by "
        return f"{said}{'; or from '.join(ways[:MAX_WAYS])}{_rest(ways)}{never}."

    def _way(self, makers: list[Maker]) -> str:
        first = makers[0]
        more = f" (and {len(makers) - 1} more like it)" if len(makers) > 1 else ""
        return f"{_BY[first.kind]}{first.name}{more}, which needs {self.lacking(first.blocker)[0]}"

    def nothing(self, want: Want) -> str:
        """The sentence about a want that nothing brings about."""
        meaning = self.words.meaning(want.bit)
        if not want.is_set:
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
        """Neither the start nor actions nor rules: the part of a sentence behind the colon."""
        return f"{self._at_the_start(meaning)}, {self.origins.nobody(meaning)}"

    def _at_the_start(self, meaning: Meaning) -> str:
        group = meaning.group
        if isinstance(group, TermBits | AtomBits):
            for bit in bits_of(self._initial & group.known):
                return f"{self.words.meaning(bit).text} holds at the start"
        return "it is not known at the start"


def _rest(ways: list[str]) -> str:
    return f"; or from {counted(len(ways) - MAX_WAYS, 'other way')}" if len(ways) > MAX_WAYS else ""
