"""External procedures that a caller supplies: pure functions of their arguments, called as rarely as possible.

Equal arguments must have equal answers, so each call is made once. A procedure with a parameter `seed` is called
again with the next seed if it fails or returns no value [K 3.3: re-sampling]. With lazy order, the search assumes
that calls succeed, and they are made in order along the plan that it finds. With eager order, they are made when
the search reaches them. Adaptive order is lazy until a procedure fails so often that making all its calls in
advance is cheaper than finding plans that are refused. Calls inside formulas and effects are made when the formula
or effect is evaluated.
"""

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from time import perf_counter
from typing import Any

from kabo import tuning
from kabo.errors import Diagnostic, InputError
from kabo.knowledge import GroundedTask
from kabo.language.answers import checked_answer
from kabo.language.formulas import GroundCall
from kabo.language.problem import Answer, Answers, Problem
from kabo.options import GeometryOrder, Search
from kabo.planner.search.skeleton import Skeleton, Trace

Function = Callable[..., Any]  # true or false of tests, a value of others


@dataclass
class CallCounts:
    """The number of calls of one procedure, and of those that failed."""

    calls: int = 0
    failures: int = 0


@dataclass
class ExternalProcedures:
    """The external procedures of one run; to the search they are a geometry with a single state.

    Raises (from every call):
        InputError: an answer is not as the procedure's declaration allows.
        Exception: whatever a procedure itself raises.
    """

    problem: Problem
    functions: Mapping[str, Function]
    order: GeometryOrder
    seed: int = 0
    counted: dict[str, CallCounts] = field(default_factory=dict)
    seconds: float = 0.0
    start: Trace = None

    def __post_init__(self) -> None:
        self._answers: dict[GroundCall, Answer] = {}
        self._takes_seed = {name: _takes_seed(function) for name, function in self.functions.items()}

    def answering(self) -> Problem:
        """The problem, with the supplied functions answering its external procedure calls."""
        return replace(self.problem, answers=Answers(frozenset(self.functions), self.value))

    # ---------------------------------------------------------------------------------- what the search may ask
    def options(self, call: GroundCall, trace: Trace) -> Sequence[tuple[int, Trace]]:
        """Attempt 0 with the unchanged trace, or no attempt if the call is refused."""
        answer = self.ask(call) if self.order == "eager" else self._answers.get(call, True)
        return ((0, trace),) if answer is not False else ()

    def key(self, trace: Trace) -> Trace:
        """The trace itself, which is the same at all nodes because there is no geometric state."""
        return trace

    def confirm(self, trace: Trace) -> bool:
        """True: calls are made at once by the other methods, so none is ever pending."""
        return True

    def test(self, call: GroundCall, trace: Trace) -> bool:
        """Whether a test inside a formula succeeds; it is called only if the preceding conjuncts hold."""
        return self.ask(call)

    def refused_everywhere(self) -> "tuple[frozenset[GroundCall], bool]":
        """The refused calls; and True, because answers depend on arguments alone and so hold in all states."""
        return frozenset(self.failed()), True

    def learnt(self) -> None:
        """None: `refused_everywhere` returns all refusals."""

    def most_expansions(self, search: Search) -> float:
        """Infinity: only the budget of the run limits the search."""
        return inf

    # -------------------------------------------------------------------------------------------------- asking
    def ask(self, call: GroundCall) -> bool:
        """Whether a call succeeds; always True for a procedure without a function."""
        return self.value(call) is not False

    def value(self, call: GroundCall) -> Answer:
        """The answer to a call, computed once and remembered; True for a procedure without a function."""
        if call.procedure not in self.functions:
            return True
        if call not in self._answers:
            counted = self.counted.setdefault(call.procedure, CallCounts())
            began = perf_counter()
            self._answers[call] = self._asked(call, counted)
            self.seconds += perf_counter() - began
        return self._answers[call]

    def _asked(self, call: GroundCall, counted: CallCounts) -> Answer:
        function, options = self.functions[call.procedure], dict(call.options)
        answer: Answer = None
        for k in range(tuning.MAX_SEEDS if self._takes_seed[call.procedure] else 1):
            if self._takes_seed[call.procedure]:
                options["seed"] = self.seed + k
            counted.calls += 1
            answer = checked_answer(self.problem, call, function(*call.arguments, **options))
            if answer is not False and answer is not None:
                break
            counted.failures += 1
        return answer

    def prepare(self, task: GroundedTask) -> None:
        """Makes calls in advance: all calls if eager; if adaptive, all calls of the procedures that often fail."""
        for name in self.functions:
            counted = self.counted.get(name, CallCounts())
            often = (
                counted.calls >= tuning.MIN_EXTERNAL_CALLS
                and counted.failures >= tuning.EXTERNAL_FAILURE_SHARE * counted.calls
            )
            if self.order == "eager" or (self.order == "adaptive" and often):
                for action in task.actions:
                    if action.call is not None and action.call.procedure == name:
                        self.ask(action.call)

    def follow(self, skeleton: Skeleton) -> bool:
        """Makes the calls along a skeleton until one fails; returns True if all succeed."""
        for node in skeleton.nodes():
            if node.action is not None and node.action.call is not None and not self.ask(node.action.call):
                return False
        return True

    def failed(self) -> list[GroundCall]:
        """All refused calls, in the order in which they were made."""
        return [call for call, answer in self._answers.items() if answer is False]

    def figures(self) -> dict[str, Any]:
        """The calls and failures of each procedure, and the total time [s], as statistics of the result."""
        rows = {
            name: {"calls": counted.calls, "failures": {"refused": counted.failures} if counted.failures else {}}
            for name, counted in self.counted.items()
        }
        return {"procedures": rows, "geometric_s": self.seconds}


def refuse_without_motion(problem: Problem) -> None:
    """Checks that no action calls an external procedure; in a problem with a scene, only formulas may.

    Raises:
        InputError: an action calls an external procedure.
    """
    calls = [action.geometry for action in problem.domain.actions.values() if action.geometry is not None]
    found = [
        Diagnostic(
            place.file,
            place.line,
            place.column,
            f'the procedure "{call.procedure}" moves nothing in the scene',
            "ask it in a precondition",
            length=place.length,
        )
        for call in calls
        if call.procedure in problem.domain.procedures and (place := call.place) is not None
    ]
    if found:
        raise InputError(found)


def _takes_seed(function: Function) -> bool:
    try:
        return "seed" in inspect.signature(function).parameters
    except (TypeError, ValueError):
        return False
