"""Two properties of the states in a container's graph, kept up to date after each change [T 3.5].

A solution is an edge between two states. The two properties of a state, for each side, are: the best path (the
longest, of equally long ones the cheapest) from that side to the state; and whether the state is *alive* on that
side, that is, whether solutions connect it with the container's border there, or may still do so. Whether a state
is alive depends only on states farther on the same side, so updating ends. A job is parked while the states that
it reads are not alive, and queued again when they are.
"""

from kabo.tasks.core.model.solutions import LEFT, RIGHT, State

Best = tuple[int, int, float]  # stages in this container, stages outside, cost


def better(first: Best, second: Best) -> bool:
    """Whether the first path is longer than the second, or equally long and cheaper."""
    longer = first[0] + first[1] - second[0] - second[1]
    return longer > 0 or (longer == 0 and first[2] < second[2])


def meet(first: object, second: object) -> bool:
    """Whether states of two lanes may be joined: the lanes are the same, or at least one state is in no lane."""
    return first is second or first is None or second is None


def relax(waiting: list[tuple[State, State, float, int]]) -> None:
    """Propagates the best paths from state to state along edges.

    Args:
        waiting: the edges to examine, as (near, far, cost, side): coming from `side`, near is reached before far.
    """
    while waiting:
        near, far, cost, side = waiting.pop()
        stages, outside, total = near.best[side]
        offered = (stages + 1, outside, total + cost)
        if better(offered, far.best[side]):
            _set_best(far, side, offered, waiting)


def _set_best(state: State, side: int, best: Best, waiting: list[tuple[State, State, float, int]]) -> None:
    """Records a better path from `side` to a state and passes it on: along edges, to counterparts inside, to job queues."""
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
    """Updates which of the given states are alive, and all states that depend on them.

    Returns the number of changes.
    """
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
