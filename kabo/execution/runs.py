"""How a run ended, and what it has come to."""

from dataclasses import dataclass, field

from kabo.execution.log import Log
from kabo.execution.watching import Surprise
from kabo.plan import State


@dataclass(frozen=True)
class Run:
    """How a run ended.

    Attributes:
        reached_goal: whether a goal node was reached.
        reason: why it stopped, in a sentence; what was reached, otherwise.
        node: the node at which it ended.
        history: the nodes that were done, in order, each with the outcome that was observed, if any; after a surprise,
            nodes of the plan that it went on with.
        state: what was done since the problem began, and where everything is by what was observed last.
        surprise: what no proof covers, if that was the reason.
        log: all that happened.
    """

    reached_goal: bool
    reason: str
    node: str
    history: tuple[tuple[str, str | None], ...]
    state: State
    surprise: Surprise | None = None
    log: Log = field(default_factory=Log, repr=False, compare=False)
