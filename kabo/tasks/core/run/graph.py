"""The graph of one container: states between its children, best paths through them, and what may still be of use.

A solution is an edge from one position to the next. Two things are kept up to date for every state and side: the
longest, then cheapest path that leads there [T 3.5], and whether the state is *alive*, that is, whether something on
that side leads on to the border, or may yet. Whether a state is alive depends on what is farther on that side alone, so
a change is followed from state to state and comes to an end. What only dead states would need is not done; when one of
them revives, it is.
"""

from kabo.tasks.core.model.solutions import LEFT, RIGHT, State

Best = tuple[int, int, float]  # stages in this container, stages outside, cost


def better(first: Best, second: Best) -> bool:
    """Whether a path is longer, or as long and cheaper."""
    longer = first[0] + first[1] - second[0] - second[1]
    return longer > 0 or (longer == 0 and first[2] < second[2])


def meet(first: object, second: object) -> bool:
    """Whether states of two lanes may be joined: of one lane, or of none in particular."""
    return first is second or first is None or second is None


def relax(waiting: list[tuple[State, State, float, int]]) -> None:
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
