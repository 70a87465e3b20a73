"""The graph of one container: states between its children, best paths through them, and what may still be of use.

A solution is an edge from one position to the next. Two things are kept up to date for every state and side: the
longest, then cheapest path that leads there [T 3.5], and whether the state is *alive*, that is, whether something on
that side leads on to the border, or may yet. Whether a state is alive depends on what is farther on that side alone, so
a change is followed from state to state and comes to an end. What only dead states would need is not done; when one of
them revives, it is.
"""

from typing import TYPE_CHECKING

from kabo.tasks.core.model.solutions import LEFT, RIGHT, Solution, State

if TYPE_CHECKING:
    from kabo.tasks.core.run.nodes import Node

Best = tuple[int, int, float]  # stages in this container, stages outside, cost


def better(first: Best, second: Best) -> bool:
    """Whether a path is longer, or as long and cheaper."""
    longer = first[0] + first[1] - second[0] - second[1]
    return longer > 0 or (longer == 0 and first[2] < second[2])


def meet(first: object, second: object) -> bool:
    """Whether states of two lanes may be joined: of one lane, or of none in particular."""
    return first is second or first is None or second is None


class Level:
    """The states between the children of one container (or beside the child of a wrapper), and their edges."""

    def __init__(self, owner: "Node") -> None:
        self.owner = owner
        self.children: list[Node] = []
        self.top = False  # whether this is the task's own level: its borders are the goal

    # --------------------------------------------------------------------------------------------- growing
    def enter(self, outer: State, side: int, number: int, lane: object) -> State:
        """The counterpart of a state that comes in at a border."""
        inner = State(outer.scene, outer.properties, number, lane)
        inner.level, inner.announced = self, True
        inner.position = 0 if side == LEFT else len(self.children)
        inner.outside.append(outer)
        outer.inside.append(inner)
        near = outer.best[side]
        inner.reached(side, (0, near[0] + near[1], near[2]))
        inner.alive[side] = outer.alive[side] or self.owner.kept
        self.owner.planning.touch(inner, 1 - side)
        self.owner.planning.touch(outer, 1 - side)
        return inner

    def add(self, solution: Solution, index: int) -> None:
        """Adds a success of the child at `index`; new states go on to its neighbours."""
        start, end = solution.start, solution.end
        if start is None or end is None:
            raise ValueError("a success has a state on both sides")
        for state, position in ((start, index), (end, index + 1)):
            if state.level is None:
                state.level, state.position = self, position
        start.edges[RIGHT].append(solution)
        end.edges[LEFT].append(solution)
        _relax([(start, end, solution.cost, LEFT), (end, start, solution.cost, RIGHT)])
        for state, side in ((start, LEFT), (end, RIGHT)):
            far = 1 - side
            if not state.announced:
                state.announced = True
                neighbour = self.neighbour(state, side)
                if neighbour is not None and neighbour.reads[far]:
                    neighbour.take(state, far, state.lane)
                self.owner.planning.touch(state, side)
            other = end if state is start else start
            if state.alive[far] != other.alive[far]:
                self.owner.planning.touch(state, far)

    def neighbour(self, state: State, side: int) -> "Node | None":
        """The child on that side of a state; None at the border."""
        k = state.position if side == RIGHT else state.position - 1
        return self.children[k] if 0 <= k < len(self.children) else None

    def at_border(self, state: State, side: int) -> bool:
        """Whether nothing of this container is on that side of a state."""
        return state.position == (0 if side == LEFT else len(self.children))

    def complete(self, state: State, side: int) -> bool:
        """Whether a path leads from the state to the border on that side."""
        needed = state.position if side == LEFT else len(self.children) - state.position
        return state.best[side][0] == needed

    # --------------------------------------------------------------------------------------------- support
    def supported(self, state: State, side: int) -> bool:
        """Whether something on that side of a state may yet lead on, where no solution does."""
        neighbour = self.neighbour(state, side)
        if neighbour is not None:
            if neighbour.reads[1 - side]:
                return neighbour.works_on(state, side)
            # Written by a container, it may have more ways through that container.
            return any(inner.alive[side] for inner in state.inside if inner.level.at_border(inner, 1 - side))
        if self.top or self.owner.kept or not state.outside or self.owner.works_at_border(state):
            return True
        return any(outer.alive[side] for outer in state.outside)

    def _may_add(self, state: State, side: int, lane: object) -> bool:
        """Whether the neighbour on that side may still make edges that lead on from a state."""
        neighbour = self.neighbour(state, side)
        if neighbour is None:
            return False
        if neighbour.reads[1 - side]:
            return neighbour.may_add(state, side, lane)
        written = (inner for inner in state.inside if inner.level.at_border(inner, 1 - side))
        return any(inner.level.owner.may_lead(inner, side) for inner in written)

    def may_extend(self, state: State, side: int) -> bool:
        """Whether anything may still be added to the paths, of its lane, that lead on from a state."""
        seen, waiting = {state}, [state]
        while waiting:
            here = waiting.pop()
            if self._may_add(here, side, state.lane):
                return True
            for edge in here.edges[side]:
                far = edge.end if side == RIGHT else edge.start
                if far is not None and far not in seen and meet(far.lane, state.lane):
                    seen.add(far)
                    waiting.append(far)
        return False

    def delivers(self, position: int, side: int) -> bool:
        """Whether new states may still come to a position from that side."""
        k, step = (position, 1) if side == RIGHT else (position - 1, -1)
        while 0 <= k < len(self.children):
            child = self.children[k]
            if child.reads[1 - side]:
                return False
            if child.busy():
                return True
            if not child.reads[side]:
                return False
            k += step
        return self.owner.border_delivers(side)


def _relax(waiting: list[tuple[State, State, float, int]]) -> None:
    """Carries better paths on: each entry is (near, far, cost, side): far is reached through near, from `side`."""
    while waiting:
        near, far, cost, side = waiting.pop()
        stages, outside, total = near.best[side]
        offered = (stages + 1, outside, total + cost)
        if better(offered, far.best[side]):
            _set_best(far, side, offered, waiting)


def _set_best(state: State, side: int, best: Best, waiting: list[tuple[State, State, float, int]]) -> None:
    """Notes a better path to a state from `side` and hands it on: along edges, to the inside, to queues."""
    entries = [(state, best)]
    while entries:
        here, value = entries.pop()
        here.reached(side, value)
        for edge in here.edges[1 - side]:
            far = edge.end if side == LEFT else edge.start
            if far is not None:
                waiting.append((here, far, edge.cost, side))
        if here.level is not None and here.announced:
            neighbour = here.level.neighbour(here, 1 - side)
            if neighbour is not None and neighbour.reads[side]:
                neighbour.rekey(here, side)
        for inner in here.inside:
            offered = (0, value[0] + value[1], value[2])
            if inner.level.at_border(inner, side) and better(offered, inner.best[side]):
                entries.append((inner, offered))


def reconsider(waiting: list[tuple[State, int]]) -> int:
    """Finds out which of the states are alive on the given side, and on whom that tells; how many have changed."""
    changed = 0
    while waiting:
        state, side = waiting.pop()
        level = state.level
        if level is None or state.alive[side] == (state.leads_on(side) or level.supported(state, side)):
            continue
        state.alive[side] = not state.alive[side]
        changed += 1
        for edge in state.edges[1 - side]:
            near = edge.start if side == RIGHT else edge.end
            if near is not None:
                waiting.append((near, side))
        waiting.extend((inner, side) for inner in state.inside if inner.level.at_border(inner, side))
        if level.at_border(state, 1 - side):
            waiting.extend((outer, side) for outer in state.outside)
        neighbour = level.neighbour(state, 1 - side)
        if neighbour is not None and neighbour.reads[side]:
            waiting.extend((partner, side) for partner in neighbour.partners(state, 1 - side))
            if state.alive[side]:
                neighbour.revived(state)
        if state.alive[side] and level.at_border(state, side):
            level.owner.revived_inside(state)
    return changed
