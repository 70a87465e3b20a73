"""Which way states flow through a stage: its two arrows, and the names by which people know them [T 3.2]."""

from enum import Enum


class Flow(Enum):
    """What a stage reads and writes; the value shows its arrows, at its start and at its end."""

    GENERATE = "← →"
    FORWARD = "→ →"
    BACKWARD = "← ←"
    CONNECT = "→ ←"

    @property
    def reads_start(self) -> bool:
        """Whether states come to it from the stage before."""
        return self in (Flow.FORWARD, Flow.CONNECT)

    @property
    def reads_end(self) -> bool:
        """Whether states come to it from the stage after."""
        return self in (Flow.BACKWARD, Flow.CONNECT)


Flows = frozenset[Flow]
PROPAGATE: Flows = frozenset((Flow.FORWARD, Flow.BACKWARD))
