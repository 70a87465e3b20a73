"""The flows of states through a stage: generate, forward, backward, connect; written as two arrows [T 3.2]."""

from enum import Enum


class Flow(Enum):
    """The interfaces that a stage reads and writes; the value shows the arrows at its start and at its end."""

    GENERATE = "← →"
    FORWARD = "→ →"
    BACKWARD = "← ←"
    CONNECT = "→ ←"

    __hash__ = object.__hash__  # there is one object of each, and the hash of an enum takes long

    @property
    def reads_start(self) -> bool:
        """Whether the stage reads the states written by the stage before it."""
        return self in (Flow.FORWARD, Flow.CONNECT)

    @property
    def reads_end(self) -> bool:
        """Whether the stage reads the states written by the stage after it."""
        return self in (Flow.BACKWARD, Flow.CONNECT)


Flows = frozenset[Flow]
PROPAGATE: Flows = frozenset((Flow.FORWARD, Flow.BACKWARD))
