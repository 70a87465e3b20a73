"""External procedures inside formulas and effects: tests, and values `K(f = g(x))` [K 3.3.1; PKS external procedures].

What they answer depends on their arguments alone, so no bit of a state says it: it is asked when a query comes to it,
after all that stands before it, and once for equal arguments.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from kabo.knowledge.numbers import NumberTerm
from kabo.knowledge.queries import (
    GeometricOracle,
    Query,
    Signed,
    conjunction,
    disjunction,
    optimistic,
    union,
)
from kabo.language.formulas import External, GroundCall, Term
from kabo.language.problem import Answer, Problem

Ask = Callable[[GroundCall], Answer]
Names = Callable[[tuple[Term, ...]], Iterator[tuple[Query, tuple[str, ...]]]]


@dataclass(frozen=True)
class Called:
    """A call of which numbers may have to be read from the state."""

    procedure: str
    arguments: tuple[str | float | NumberTerm, ...]
    ask: Ask = field(compare=False, repr=False)

    @property
    def reads(self) -> int:
        """The bits of all numbers among the arguments."""
        return union(each.reads for each in self.arguments if isinstance(each, NumberTerm))

    def answer(self, state: int) -> Answer:
        """What the procedure answers; None also if an argument is not known."""
        values = tuple(each.value(state) if isinstance(each, NumberTerm) else each for each in self.arguments)
        return None if None in values else self.ask(GroundCall(self.procedure, values))  # type: ignore[arg-type]


@dataclass(frozen=True)
class Answered(Signed):
    """Whether a call is answered so; `positive` is False for "not known to be answered so"."""

    called: Called
    value: Answer
    positive: bool = True

    has_tests = True

    @property
    def reads(self) -> int:
        """The bits of numbers among the arguments."""
        return self.called.reads

    def holds(self, state: int, test: GeometricOracle = optimistic) -> bool:
        """Asks."""
        return (self.called.answer(state) == self.value) == self.positive

    def support(self, state: int, test: GeometricOracle = optimistic) -> int:
        """The numbers: equal arguments are answered equally."""
        return self.reads

    def possible(self, ones: int, zeros: int) -> bool:
        """Nobody is asked in the relaxation."""
        return True


class Externals:
    """Compiles the calls of one problem; how arguments are compiled is the compiler's business."""

    def __init__(self, problem: Problem, names: Names, number: Callable[[Term], NumberTerm]) -> None:
        self.problem, self._names, self._number = problem, names, number

    def _calls(self, external: External) -> Iterator[tuple[Query, Called]]:
        """The call for whatever objects its arguments are known to be, each with the condition for it."""
        kinds = self.problem.domain.procedures[external.procedure].arguments
        ask = self.problem.answers.ask if self.problem.answers is not None else _nobody
        is_number = [kind == "number" for kind in kinds]
        objects = tuple(a for a, number in zip(external.arguments, is_number, strict=True) if not number)
        numbers = [
            _settled(self._number(a)) for a, number in zip(external.arguments, is_number, strict=True) if number
        ]
        for condition, names in self._names(objects):
            own, others = iter(names), iter(numbers)
            arguments = tuple(next(others) if number else next(own) for number in is_number)
            yield condition, Called(external.procedure, arguments, ask)

    def cases(self, external: External) -> Iterator[tuple[Query, str]]:
        """The objects that the answer may be, each with the condition for it."""
        for condition, called in self._calls(external):
            for value in self.problem.answers_of(external.procedure):
                yield conjunction([condition, Answered(called, value)]), value

    def test(self, external: External) -> Query:
        """Whether a test succeeds."""
        return disjunction(
            conjunction([condition, Answered(called, True)]) for condition, called in self._calls(external)
        )

    def number(self, external: External) -> NumberTerm:
        """A number as it is answered."""
        choices = list(self._calls(external))

        def value(state: int) -> float | None:
            for condition, called in choices:
                if condition.holds(state):
                    answer = called.answer(state)
                    return answer if isinstance(answer, float) else None
            return None

        return NumberTerm(union(condition.reads | called.reads for condition, called in choices), value, asks=True)


def _settled(number: NumberTerm) -> str | float | NumberTerm:
    """The number itself if it depends on nothing."""
    value = None if number.reads or number.asks else number.value(0)
    return number if value is None else value


def _nobody(_call: GroundCall) -> Answer:
    """Tests that nobody answers for succeed; values that nobody answers for were refused before."""
    return True
