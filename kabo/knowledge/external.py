"""External procedures in formulas and effects: tests, and values `K(f = g(x))` [K 3.3.1; PKS external procedures].

The answer of a procedure depends on its arguments alone, so it takes no bits of states. A procedure is called only
when the evaluation of a query reaches it, after the parts of the query before it, and only once for equal
arguments.
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
    """A call of an external procedure, some of whose arguments may be numbers that are read from the state."""

    procedure: str
    arguments: tuple[str | float | NumberTerm, ...]
    ask: Ask = field(compare=False, repr=False)

    @property
    def reads(self) -> int:
        """The bits of the numbers among the arguments."""
        return union(each.reads for each in self.arguments if isinstance(each, NumberTerm))

    def answer(self, state: int) -> Answer:
        """The procedure's answer; None if it has none or an argument is not known."""
        values = tuple(each.value(state) if isinstance(each, NumberTerm) else each for each in self.arguments)
        return None if None in values else self.ask(GroundCall(self.procedure, values))  # type: ignore[arg-type]


@dataclass(frozen=True)
class Answered(Signed):
    """The query whether a call has the answer `value`; with `positive` False, whether that is not known."""

    called: Called
    value: Answer
    positive: bool = True

    has_tests = True

    @property
    def reads(self) -> int:
        """The bits of the numbers among the arguments."""
        return self.called.reads

    def holds(self, state: int, test: GeometricOracle = optimistic) -> bool:
        """Whether the call has the answer `value`, or with `positive` False has not; calls the procedure."""
        return (self.called.answer(state) == self.value) == self.positive

    def support(self, state: int, test: GeometricOracle = optimistic) -> int:
        """The bits of the numbers among the arguments, on which alone the answer depends."""
        return self.reads

    def possible(self, ones: int, zeros: int) -> bool:
        """True: the relaxation calls no procedure."""
        return True


class Externals:
    """Compiles the external calls of one problem; the compiler passes functions that compile their arguments."""

    def __init__(self, problem: Problem, names: Names, number: Callable[[Term], NumberTerm]) -> None:
        self.problem, self._names, self._number = problem, names, number

    def _calls(self, external: External) -> Iterator[tuple[Query, Called]]:
        """The call with each tuple of objects that its arguments may be known to be, and the condition for each."""
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
        """Pairs of a condition and an object: where the condition holds, the procedure answers this object."""
        for condition, called in self._calls(external):
            for value in self.problem.answers_of(external.procedure):
                yield conjunction([condition, Answered(called, value)]), value

    def test(self, external: External) -> Query:
        """The query whether an external test succeeds."""
        return disjunction(
            conjunction([condition, Answered(called, True)]) for condition, called in self._calls(external)
        )

    def number(self, external: External) -> NumberTerm:
        """The number that a procedure answers."""
        choices = list(self._calls(external))

        def value(state: int) -> float | None:
            for condition, called in choices:
                if condition.holds(state):
                    answer = called.answer(state)
                    return answer if isinstance(answer, float) else None
            return None

        return NumberTerm(union(condition.reads | called.reads for condition, called in choices), value, asks=True)


def _settled(number: NumberTerm) -> str | float | NumberTerm:
    """The argument, as a constant if it reads no bit and calls no procedure."""
    value = None if number.reads or number.asks else number.value(0)
    return number if value is None else value


def _nobody(_call: GroundCall) -> Answer:
    """True for tests of procedures without a function; values of such procedures were refused before."""
    return True
