"""The memories of lists of bodies, which views of the same bodies share: those that were used last are kept."""

from collections import OrderedDict
from collections.abc import Sequence

from kabo.geometry.budget import Budget
from kabo.geometry.collision.body_memory import BodyMemory
from kabo.geometry.collision.part_trees import known, require_fine
from kabo.geometry.collision.root_answers import budget_of_roots
from kabo.geometry.parts import Enclosure, FixedGroup, MovingGroup
from kabo.scene import KinematicTree

MAX_MEMORIES = 24  # lists of bodies whose arrays are kept: a scene has one for each robot and what it carries


class BodyMemories:
    """The memories of some lists of bodies; those that were not used for the longest time are dropped."""

    def __init__(self) -> None:
        self._of: OrderedDict[tuple[object, ...], BodyMemory] = OrderedDict()
        self._checked: OrderedDict[tuple[object, ...], Budget | None] = OrderedDict()

    def budget_of_roots(self, enclosures: tuple[Enclosure, ...], budget: Budget) -> Budget | None:
        """`root_answers.budget_of_roots` of enclosures that are fine enough for a budget.

        Raises:
            ValueError: one of them never is.
        """
        key = enclosures, budget
        if key not in self._checked:
            for each in enclosures:
                require_fine(each, budget.geometry)
            self._checked[key] = budget_of_roots(enclosures, budget)
            if len(self._checked) > MAX_MEMORIES:
                self._checked.popitem(last=False)
        self._checked.move_to_end(key)
        return self._checked[key]

    def of(
        self,
        tree: KinematicTree,
        moving: Sequence[MovingGroup],
        fixed: Sequence[FixedGroup],
        pairs: int,
        budget: Budget,
    ) -> BodyMemory:
        """The memory of bodies with the parts that are known of them by now, for so many pairs at least.

        Raises:
            ValueError: as `BodyMemory`.
        """
        given: tuple[MovingGroup | FixedGroup, ...] = (*moving, *fixed)
        joints = tuple(group.joint for group in moving)
        enclosures = tuple(group.enclosure for group in given)
        most = max(pairs, len(moving) * len(given))
        key = id(tree), joints, enclosures, tuple(map(known, enclosures)), budget, most
        found = self._of.get(key)
        if found is None:
            self._of[key] = found = BodyMemory(tree, given, joints, budget, most)
            if len(self._of) > MAX_MEMORIES:
                self._of.popitem(last=False)
        self._of.move_to_end(key)
        return found
