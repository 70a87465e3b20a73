"""External procedures that a caller supplies: pure functions of their arguments, asked as rarely as may be.

Equal arguments have equal answers, so each call is made once; a procedure that takes a `seed` is asked again with the
next one where it failed [K 3.3: re-sampling]. Lazy: taken to succeed by the search, asked along the plan that it
finds, in order, and refused from the first failure on. Eager: asked when the search meets them. Adaptive: lazy, until
a procedure fails so often that asking for all its calls at once is cheaper than finding plans in vain.
"""

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from time import perf_counter

from kabo.knowledge import Task
from kabo.language.formulas import GroundCall
from kabo.planner.skeleton import Skeleton, Trace

Function = Callable[..., bool]

SEEDS = 16  # how often a procedure that takes a seed is asked before its arguments count as refused
LEAST_CALLS = 8  # before the share of failures says anything
OFTEN = 0.35  # the share of failures from which on all calls of a procedure are asked at once


@dataclass
class Counted:
    """What one procedure did so far."""

    calls: int = 0
    failures: int = 0


@dataclass
class Procedures:
    """The procedures of one run; as the search sees geometry, but without any state behind it.

    Raises (from every question):
        Exception: what a procedure itself raises.
    """

    functions: Mapping[str, Function]
    order: str
    seed: int = 0
    counted: dict[str, Counted] = field(default_factory=dict)
    seconds: float = 0.0
    start: Trace = None

    def __post_init__(self) -> None:
        self._answers: dict[GroundCall, bool] = {}
        self._takes_seed = {name: _takes_seed(function) for name, function in self.functions.items()}

    # ---------------------------------------------------------------------------------- what the search may ask
    def options(self, call: GroundCall, trace: Trace) -> Sequence[tuple[int, Trace]]:
        """The one attempt at a call, unless it is refused."""
        answer = self.ask(call) if self.order == "eager" else self._answers.get(call, True)
        return ((0, trace),) if answer else ()

    def key(self, trace: Trace) -> Trace:
        """Nothing tells nodes apart."""
        return trace

    def test(self, call: GroundCall, trace: Trace) -> bool:
        """A test inside a formula is asked where it is met: conjunctions have checked all before it."""
        return self.ask(call)

    def refused_everywhere(self) -> "tuple[frozenset[GroundCall], bool]":
        """Every refusal is one of arguments alone."""
        return frozenset(call for call, answer in self._answers.items() if not answer), True

    # -------------------------------------------------------------------------------------------------- asking
    def ask(self, call: GroundCall) -> bool:
        """The answer to a call; a procedure that nobody supplied always succeeds."""
        if call.procedure not in self.functions:
            return True
        if call not in self._answers:
            counted = self.counted.setdefault(call.procedure, Counted())
            began = perf_counter()
            self._answers[call] = self._asked(call, counted)
            self.seconds += perf_counter() - began
        return self._answers[call]

    def _asked(self, call: GroundCall, counted: Counted) -> bool:
        function, options = self.functions[call.procedure], dict(call.options)
        for k in range(SEEDS if self._takes_seed[call.procedure] else 1):
            if self._takes_seed[call.procedure]:
                options["seed"] = self.seed + k
            counted.calls += 1
            if function(*call.arguments, **options):
                return True
            counted.failures += 1
        return False

    def prepare(self, task: Task) -> None:
        """Asks all calls of the procedures whose turn it is: all of them if eager, those that fail often if adaptive."""
        for name in self.functions:
            counted = self.counted.get(name, Counted())
            often = counted.calls >= LEAST_CALLS and counted.failures >= OFTEN * counted.calls
            if self.order == "eager" or (self.order == "adaptive" and often):
                for action in task.actions:
                    if action.call is not None and action.call.procedure == name:
                        self.ask(action.call)

    def follow(self, skeleton: Skeleton) -> bool:
        """Asks along a skeleton until something fails; whether all of it succeeds."""
        for node in skeleton.nodes():
            if node.action is not None and node.action.call is not None and not self.ask(node.action.call):
                return False
        return True

    def failed(self) -> list[GroundCall]:
        """All refused calls, in the order in which they were asked."""
        return [call for call, answer in self._answers.items() if not answer]


def _takes_seed(function: Function) -> bool:
    try:
        return "seed" in inspect.signature(function).parameters
    except (TypeError, ValueError):
        return False
