"""The surprises after which a run went on, and when it gives up: what comes again at the same action will come again."""

from dataclasses import dataclass, field
from typing import NamedTuple

from kabo.execution.interruptions import Stop
from kabo.execution.watching import Surprise
from kabo.plan import Node

MOST_ALIKE = 3  # surprises by one thing at one action, until the run ends


class _Recovered(NamedTuple):
    """A surprise: how many nodes were done before it, the thing, whether it was on a way out of a node, and the action."""

    done: int
    thing: str
    on_way: bool
    action: tuple[str, ...]


@dataclass
class Repetitions:
    """The surprises of a run, in order; `most` are answered at most."""

    most: int
    answers: int = 0
    _found: list[_Recovered] = field(default_factory=list)
    _last: Surprise | None = None

    def add(self, stop: Stop, node: Node, done: int, *, on_way: bool) -> str | None:
        """Counts one more surprise that is to be answered; or says, as the end of a sentence, why the run gives up.

        Args:
            stop: how the run stopped, by a surprise. node: at which the run stands. done: how many nodes were done.
            on_way: whether it was on a way out of a node: that ends only the way.
        """
        assert stop.surprise is not None
        if self.answers >= self.most:
            return f"the run gives up after {self.most} answers" if self.most else ""
        self.answers += 1
        if stop.surprise is self._last:  # after a way out of a node it is still the same
            return None
        self._last = stop.surprise
        now = _Recovered(done, stop.surprise.thing, on_way, _action(node))
        alike = [each for each in self._found if each[1:] == now[1:]]
        if not on_way and len(alike) >= MOST_ALIKE:
            name, *arguments = now.action[0], *map(str, node.arguments.values())
            where = f"{name}({', '.join(arguments)})" if arguments else name
            return (
                f"again and again: {now.thing} has surprised {len(alike) + 1} times at {where}, the run gives up"
            )
        self._found.append(now)
        return None

    def is_again(self) -> bool:
        """Whether the last surprise was by the same thing as one before it, after as many nodes."""
        *before, last = [each[:2] for each in self._found]
        return last in before


def _action(node: Node) -> tuple[str, ...]:
    """The action of a node and its arguments, or what it asks: nodes of an answer have other names for the same."""
    return (str(node.action or node.on or node.kind), *(f"{k}={v}" for k, v in sorted(node.arguments.items())))
