"""Whether a small problem has a plan, by brute force on beliefs: sets of worlds, as slow and obvious as can be.

A world is the frozenset of the atoms that hold. An action may be done where its precondition holds in every world; it maps
worlds to worlds, additions win; seeing an atom splits the belief. A belief is solved if the goal holds in all of its
worlds, or if some action leads to solved beliefs only: the least fixpoint over all beliefs that can be reached.
Shares no code with kabo.
"""

from itertools import product

from tests.support.random_beliefs import Act, Formula, Small

World = frozenset
Belief = frozenset


def holds(formula: Formula, world: World) -> bool:
    """Whether a formula holds in a world."""
    if formula[0] == "lit":
        return (formula[1] in world) == formula[2]
    return (all if formula[0] == "and" else any)(holds(part, world) for part in formula[1:])


def start(small: Small) -> Belief:
    """All worlds that the initial state allows; none if it contradicts itself."""
    worlds = []
    for values in product((False, True), repeat=len(small.unknown)):
        world = frozenset(small.true) | {a for a, value in zip(small.unknown, values, strict=True) if value}
        one = all(sum(atom in world for atom in each) == 1 for each in (*small.oneofs, small.term) if each)
        if one and all(any((atom in world) == truth for atom, truth in clause) for clause in small.clauses):
            worlds.append(frozenset(world))
    return frozenset(worlds)


def after(act: Act, world: World) -> World:
    """The world after an action."""
    outcomes = [
        each
        for condition, made in act.effects
        if all((atom in world) == truth for atom, truth in condition)
        for each in made
    ]
    added = {atom for atom, truth in outcomes if truth}
    return (world - {atom for atom, truth in outcomes if not truth}) | added


def outcomes(act: Act, belief: Belief) -> list[Belief] | None:
    """The beliefs that an action may lead to; None where it may not be done."""
    if not all(holds(act.precondition, world) for world in belief):
        return None
    moved = [after(act, world) for world in belief]
    return [
        frozenset(w for w in moved if _seen(act, w) == each) for each in sorted({_seen(act, w) for w in moved})
    ]


def _seen(act: Act, world: World) -> tuple[bool, ...]:
    """What an action shows of a world."""
    if act.whether:
        return (all((atom in world) == truth for atom, truth in act.whether),)
    return tuple(atom in world for atom in act.observes)


def beliefs(small: Small, limit: int = 3000) -> dict[Belief, list[list[Belief]]] | None:
    """Every belief that can be reached, with what each action may lead to; None if there are more than `limit`."""
    found: dict[Belief, list[list[Belief]]] = {}
    waiting = [start(small)]
    while waiting:
        here = waiting.pop()
        if here in found:
            continue
        if len(found) >= limit:
            return None
        choices = [outcomes(act, here) for act in small.actions]
        found[here] = [choice for choice in choices if choice is not None]
        waiting += [child for choice in found[here] for child in choice]
    return found


def solvable(small: Small, limit: int = 3000) -> bool | None:
    """Whether a strong plan exists; None if there are too many beliefs."""
    found = beliefs(small, limit)
    if found is None:
        return None
    solved = {belief for belief in found if all(holds(small.goal, world) for world in belief)}
    while True:
        new = {
            belief
            for belief, choices in found.items()
            if belief not in solved and any(all(child in solved for child in choice) for choice in choices)
        }
        if not new:
            return start(small) in solved
        solved |= new
