"""STACKED n OBJECTS [K 6.2.2] as a finite-domain task, built by hand."""

from kabo.finite_domain import Effect, FiniteTask, Operator, StateVariable


def stacked(n: int) -> FiniteTask:
    """Blocks 0 … n − 1 and three stacks; block 0 has to go under the tower of the others. Optimum: 2 n − 1."""
    below, highest = range(n), range(n, 2 * n + 3)  # variables; things are blocks, then stacks
    variables = [StateVariable(f"one_below({b})", n + 3) for b in range(n)]
    variables += [StateVariable(f"highest({x})", 2) for x in range(n + 3)]
    freed = [tuple(Effect(((below[b], (x,)),), highest[x], 1) for x in range(n + 3) if x != b) for b in range(n)]
    operators = []
    for b in range(n):
        for x in range(n + 3):
            if x == b:
                continue
            needed = ((highest[b], (1,)), (highest[x], (1,)))
            moved = (Effect((), highest[x], 0), Effect((), below[b], x))
            operators.append(Operator(f"move({b}, {x})", needed, (*moved, *freed[b])))
    start = [n + 1, n, *range(1, n - 1)]
    covered = set(start)
    initial = (*start, *(int(x not in covered) for x in range(n + 3)))
    goal = tuple((below[b], (b - 1 if b else n,)) for b in range(n))
    return FiniteTask(tuple(variables), initial, tuple(operators), goal)
