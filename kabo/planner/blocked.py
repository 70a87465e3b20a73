"""Why something can never be known, down to the root cause: what could make it, and what keeps that from happening.

What is alike is told once: wants with the same symbol that the same kinds of makers would bring about, and that the
same kinds of wants block, are one *case*.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from kabo.knowledge import Query
from kabo.knowledge.facts import AtomBits, ConjunctionBits, NumberBits, TermBits
from kabo.knowledge.queries import bits_of
from kabo.planner.makers import Maker, Makers
from kabo.planner.wording import Meaning, Want, Words, counted, listed, wants

MAX_WANTS = 20_000  # looked at for one explanation
MAX_SENTENCES = 8

MAX_WAYS = 4

_BY = {"does": "", "senses": "what is sensed by ", "rule": "", "entry": "knowing "}


@dataclass
class Case:
    """Like wants, the first one met first; `blockers` are the wants that block the first."""

    members: list[Want]
    makers: list[Maker]
    kinds: tuple[object, ...]


@dataclass
class Reasons:
    """Everything that keeps some wants from ever holding."""

    cases: list[Case] = field(default_factory=list)
    circular: list[Want] = field(default_factory=list)  # wait for each other, and for nothing else
    layer: int = 0  # the last layer in which something became possible that they need
    complete: bool = True


class Blocked:
    """Explains wants that the delete relaxation cannot reach."""

    def __init__(self, makers: Makers, words: Words) -> None:
        self.makers, self.words = makers, words
        self.reach = makers.whole.reach
        self._initial = makers.whole.initial
        self._blockers: dict[Want, list[tuple[Maker, list[Want]]]] = {}

    def reasons(self, query: Query) -> Reasons:
        """What keeps an impossible query from ever holding, nearest causes first."""
        queue = list(dict.fromkeys(wants(query, self.reach.ones, self.reach.zeros)))
        seen, reasons, reads = set(queue), Reasons(), query.reads
        cases: dict[tuple[object, ...], Case] = {}
        edges: dict[Want, list[Want]] = {}
        for want in queue:  # grows while it is worked on
            blockers = self._of(want)
            kinds = self._kinds(want, blockers)
            case = cases.setdefault(kinds, Case([], [maker for maker, _ in blockers], kinds))
            case.members.append(want)
            edges[want] = [other for _, found in blockers for other in found]
            for maker, _ in blockers:
                reads |= maker.blocker.reads
            for other in edges[want]:
                if other not in seen and len(seen) < MAX_WANTS:
                    seen.add(other)
                    queue.append(other)
        reasons.cases = list(cases.values())
        reasons.complete = len(seen) < MAX_WANTS
        reasons.circular = _circular(edges) if reasons.complete else []
        reasons.layer = self._layer(reads)
        return reasons

    def sentences(self, reasons: Reasons, most: int = MAX_SENTENCES) -> list[str]:
        """The reasons for people; those that rest on nothing else are never left out."""
        roots = [case for case in reasons.cases if not case.makers]
        shown = [case for number, case in enumerate(reasons.cases) if number < most or case in roots[:most]]
        told = [self._sentence(case) for case in shown]
        if len(shown) < len(reasons.cases):
            more = len(reasons.cases) - len(shown)
            told.append(f"{counted(more, 'further cause')} {'follows' if more == 1 else 'follow'} from these.")
        if reasons.circular:
            texts = [self.words.text(want) for want in reasons.circular]
            if len(texts) == 1:
                told.append(f"So {texts[0]} waits for itself, and it does not hold at the start.")
            else:
                told.append(f"So {listed(texts, 'and')} wait for each other, and none of them holds at the start.")
        return told

    def _of(self, want: Want) -> list[tuple[Maker, list[Want]]]:
        if want not in self._blockers:
            makers = self.makers.of(want)
            self._blockers[want] = [(maker, self.makers.wants(maker)) for maker in makers]
        return self._blockers[want]

    def _kinds(self, want: Want, blockers: Sequence[tuple[Maker, list[Want]]]) -> tuple[object, ...]:
        meaning = self.words.meaning(want.bit)
        makers = {(maker.kind, maker.family, self._kind_of(found)) for maker, found in blockers}
        return meaning.symbol, meaning.role, want.is_set, tuple(sorted(makers, key=repr))

    def _kind_of(self, found: Iterable[Want]) -> tuple[tuple[str, str, bool], ...]:
        meanings = {(self.words.meaning(w.bit).symbol, self.words.meaning(w.bit).role, w.is_set) for w in found}
        return tuple(sorted(meanings))

    def _layer(self, reads: int) -> int:
        """The last layer in which one of the bits became possible."""
        history, last = self.reach.history, 0
        for number in range(1, len(history)):
            if history[number][0] & ~history[number - 1][0] & reads:
                last = number
        return last

    # ---------------------------------------------------------------------------------------------- sentences
    def _sentence(self, case: Case) -> str:
        first, *others = case.members
        told = self._ways(first, case) if case.makers else self.nothing(first)
        if others:
            told += f" Likewise {listed([self.words.text(want) for want in others], 'and')}."
        return told

    def _ways(self, want: Want, case: Case) -> str:
        """What could make the want, each with what it lacks."""
        families: dict[tuple[str, str, str], list[Maker]] = {}
        for maker in case.makers:
            lacks = self._kind_of(self.makers.wants(maker))
            families.setdefault((maker.kind, maker.family, repr(lacks)), []).append(maker)
        ways = [self._way(makers) for makers in families.values()]
        never = "that never holds" if len(ways) == 1 else "none of that ever holds"
        comes = "can only come from" if want.is_set else "can only be ended by"
        return f"{self.words.text(want)} {comes} {listed(ways, 'or', MAX_WAYS)}; {never}."

    def _way(self, makers: list[Maker]) -> str:
        first = makers[0]
        lacks = self.words.query(first.blocker, self.makers.ones, self.makers.zeros)
        more = f" (and {len(makers) - 1} more like it)" if len(makers) > 1 else ""
        return f"{_BY[first.kind]}{first.name}{more}, which needs {lacks}"

    def nothing(self, want: Want) -> str:
        """The sentence about a want that nothing brings about."""
        meaning = self.words.meaning(want.bit)
        if not want.is_set:
            return f"{meaning.text} holds from the start, and nothing ever takes that away."
        about = meaning.about
        match meaning.role:
            case "true" | "false" | "equal" | "unequal":
                nobody = f"no action adds it, no update rule infers it and no action senses {about}"
                return f"Nothing makes {meaning.text}: {self._at_the_start(meaning)}, {nobody}."
            case "whether" if isinstance(meaning.group, AtomBits | ConjunctionBits):
                return (
                    f"{about} can never be known whether: it is not known at the start, and no action senses it."
                )
            case "whether" | "known" | "number":
                return f"The value of {about} can never be known: it is not known at the start, and no action senses it."
            case "always":
                return f"{about} does not hold at the start already."
        return f"Nothing tells {about}."

    def _at_the_start(self, meaning: Meaning) -> str:
        """What is known of it at the start."""
        group = meaning.group
        if isinstance(group, TermBits | AtomBits):
            for bit in bits_of(self._initial & group.known):
                return f"{self.words.meaning(bit).text} holds at the start"
            if isinstance(group, AtomBits) and self.reach.ones & group.known:
                return f"it is not known at the start, and only {self._other(meaning)} can ever become known"
        if isinstance(group, NumberBits):
            return "no number is known"
        return "it is not known at the start"

    def _other(self, meaning: Meaning) -> str:
        group = meaning.group
        assert isinstance(group, AtomBits)
        return self.words.meaning(group.false if meaning.role == "true" else group.true).text


def _circular(edges: dict[Want, list[Want]]) -> list[Want]:
    """The wants that lead to no root cause."""
    before: dict[Want, list[Want]] = {}
    for want, others in edges.items():
        for other in others:
            before.setdefault(other, []).append(want)
    rooted = [want for want, others in edges.items() if not others]
    found = set(rooted)
    for want in rooted:  # grows while it is worked on
        for other in before.get(want, ()):
            if other not in found:
                found.add(other)
                rooted.append(other)
    return [want for want in edges if want not in found]
