"""The symbolic-geometric map: every geometric state has one identifier, and so has every component [K Def. 5].

Near-equality is not transitive, so it is decided once for each number: a number maps to the nearest representative
within the tolerance, or becomes a representative itself. States whose numbers have the same representatives are
equal; representatives are totally ordered. Finding one costs O(log n), looking a state up by identifier O(1).
"""

from bisect import bisect_left, insort
from collections.abc import Hashable

from kabo.scene import Attachment, Component, GeometricState

STATE_TOLERANCE = 1e-6  # [m, rad]: states that differ less than this in every number are equal


class Representatives:
    """Sorted numbers, each of which represents all numbers within the tolerance of it."""

    def __init__(self, tolerance: float) -> None:
        self._tolerance = tolerance
        self._sorted: list[float] = []

    def of(self, number: float) -> float:
        """The nearest representative within the tolerance; if there is none, `number` becomes one and is returned."""
        i = bisect_left(self._sorted, number)
        near = [x for x in self._sorted[max(0, i - 1) : i + 1] if abs(x - number) <= self._tolerance]
        if near:
            return min(near, key=lambda x: (abs(x - number), x))
        insort(self._sorted, number)
        return number


class IdentifierMap:
    """Identifiers of components and states, numbered from 0 in the order in which they were first passed."""

    def __init__(self, tolerance: float = STATE_TOLERANCE) -> None:
        self._tolerance = tolerance
        self._numbers: dict[Hashable, Representatives] = {}
        self._components: dict[Hashable, int] = {}
        self._states: dict[tuple[int, ...], int] = {}
        self._by_identifier: list[GeometricState] = []

    def component(self, name: str, value: Component) -> int:
        """The identifier of one robot's configuration or one object's placing."""
        if isinstance(value, Attachment):
            kind: Hashable = (name, value.parent)
            numbers: tuple[float, ...] = (*value.position, *value.quaternion)
        else:
            kind, numbers = (name, None), value
        settled = tuple(
            self._numbers.setdefault((kind, i), Representatives(self._tolerance)).of(number)
            for i, number in enumerate(numbers)
        )
        return self._components.setdefault((kind, settled), len(self._components))

    def identify(self, state: GeometricState) -> int:
        """The identifier of a state; states that are equal within the tolerance have the same identifier."""
        parts: dict[str, Component] = {**state.robots, **state.objects}
        key = tuple(self.component(name, value) for name, value in sorted(parts.items()))
        if key not in self._states:
            self._states[key] = len(self._by_identifier)
            self._by_identifier.append(state)
        return self._states[key]

    def state(self, identifier: int) -> GeometricState:
        """The first state that was given this identifier."""
        return self._by_identifier[identifier]

    def __len__(self) -> int:
        return len(self._by_identifier)
