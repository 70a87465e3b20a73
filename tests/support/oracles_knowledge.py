"""Slow and obvious judges of the knowledge planner, written from docs/explanation/knowledge.md without any of its code.

A knowledge state is a frozenset of facts: ("K", atom, truth), ("Kw", atom), ("=", term, value),
("!=", term, value), ("Kv", term). A world is a dict: atom or term to its true value. Atoms and terms are
tuples (name, argument, ...).
"""

from itertools import product

from kabo.language import formulas as f
from kabo.language.problem import Action, Problem

State = frozenset
Facts = set


# ------------------------------------------------------------------------------------------------------- queries
def ground(thing, binding):
    name = thing.predicate if isinstance(thing, f.Atom) else thing.function
    return (name, *(binding.get(a.name, a.name) for a in thing.arguments))


def instances(problem: Problem, variables, binding):
    for values in product(*(problem.of_type(v.type) for v in variables)):
        yield {**binding, **{v.name: value for v, value in zip(variables, values, strict=True)}}


def value_of(state, term, binding):
    """The known value of a term, or None."""
    if isinstance(term, f.Number):
        return term.value
    if isinstance(term, f.Arithmetic):
        left, right = value_of(state, term.left, binding), value_of(state, term.right, binding)
        if left is None or right is None or (term.operator == "/" and right == 0):
            return None
        return (
            {"+": left + right, "-": left - right, "*": left * right}.get(term.operator)
            if (term.operator != "/")
            else left / right
        )
    if isinstance(term, f.Application):
        key = ground(term, binding)
        return next((fact[2] for fact in state if fact[0] == "=" and fact[1] == key), None)
    return binding.get(term.name, term.name)


def known_different(state, term, other, binding):
    value, avoid = value_of(state, term, binding), value_of(state, other, binding)
    if value is not None and avoid is not None:
        return value != avoid
    return avoid is not None and isinstance(term, f.Application) and ("!=", ground(term, binding), avoid) in state


def holds(problem: Problem, state, formula, binding):
    """Whether a query holds in a knowledge state."""

    def ask(inner, more=None):
        return holds(problem, state, inner, binding if more is None else more)

    match formula:
        case f.Truth(value=value):
            return value
        case f.Know(claim=f.Literal(atom=atom, positive=positive)):
            return ("K", ground(atom, binding), positive) in state
        case f.Know(claim=f.Comparison(operator=operator, left=left, right=right)):
            if operator == "!=":
                return known_different(state, left, right, binding) or known_different(state, right, left, binding)
            one, two = value_of(state, left, binding), value_of(state, right, binding)
            if one is None or two is None:
                return False
            return {"=": one == two}.get(operator) if operator == "=" else compare(operator, one, two)
        case f.KnowWhether(atom=atom):
            key = ground(atom, binding)
            return bool({("K", key, True), ("K", key, False), ("Kw", key)} & state)
        case f.KnowValue(term=term):
            return ("Kv", ground(term, binding)) in state or value_of(state, term, binding) is not None
        case f.Not(body=body):
            return not ask(body)
        case f.And(parts=parts):
            return all(ask(part) for part in parts)
        case f.Or(parts=parts):
            return any(ask(part) for part in parts)
        case f.Xor(first=first, second=second):
            return ask(first) != ask(second)
        case f.Forall(variables=variables, body=body):
            return all(ask(body, more) for more in instances(problem, variables, binding))
        case f.Exists(variables=variables, body=body):
            return any(ask(body, more) for more in instances(problem, variables, binding))
    raise AssertionError(formula)


def compare(operator, one, two):
    return {"<": one < two, "<=": one <= two, ">": one > two, ">=": one >= two}[operator]


def goal_holds(problem: Problem, state) -> bool:
    return all(holds(problem, state, formula, {}) for formula in problem.goal)


# ------------------------------------------------------------------------------------------------------- effects
def updates(problem: Problem, state, effects, binding):
    """All (operation, database, fact, binding) that fire in the state before."""
    for effect in effects:
        match effect:
            case f.Change():
                for fact in effect.facts:
                    yield effect.operation, effect.database, fact, binding
            case f.Conditional(condition=condition, updates=inner):
                if holds(problem, state, condition, binding):
                    yield from updates(problem, state, inner, binding)
            case f.ForEach(variables=variables, effects=inner):
                for more in instances(problem, variables, binding):
                    yield from updates(problem, state, inner, more)


def fired(problem: Problem, state, effects, sense, binding):
    """Additions and deletions, as facts of a state; "forget" for a function set to an unknown value."""
    adds, deletes = set(), set()
    sensing = [("add", "Kw" if isinstance(s, f.Atom) else "Kv", s, binding) for s in sense]
    for operation, database, fact, bound in [*updates(problem, state, effects, binding), *sensing]:
        target = adds if operation == "add" else deletes
        if isinstance(fact, f.Literal):
            key = ground(fact.atom, bound)
            target.add(("Kw", key) if database == "Kw" else ("K", key, fact.positive))
        elif isinstance(fact, f.Comparison):
            value = value_of(state, fact.right, bound)
            key = ground(fact.left, bound)
            target.add(("forget", key) if value is None else (fact.operator, key, value))
        elif isinstance(fact, f.Atom):
            target.add(("Kw", ground(fact, bound)))
        else:
            target.add(("Kv", ground(fact.term if isinstance(fact, f.TermFact) else fact, bound)))
    return adds, deletes


def contradictory(adds) -> bool:
    for fact in adds:
        if fact[0] == "K" and ("K", fact[1], not fact[2]) in adds:
            return True
        if fact[0] == "=" and ("!=", fact[1], fact[2]) in adds:
            return True
        if fact[0] == "=" and any(o[0] == "=" and o[1] == fact[1] and o[2] != fact[2] for o in adds):
            return True
    return False


def progress(problem: Problem, state, effects, sense, binding):
    """The state after, what is sensed still open; None if the updates contradict each other."""
    adds, deletes = fired(problem, state, effects, sense, binding)
    if contradictory(adds):
        return None
    after = set(state) - deletes
    for fact in adds:
        after -= displaced(fact, after)
    after |= {fact for fact in adds if fact[0] != "forget"}
    return normal(after)


def displaced(fact, state):
    """What an added fact removes."""
    kind, key = fact[0], fact[1]
    about = {other for other in state if other[1] == key}
    if kind in ("K", "=", "forget"):
        return about
    if kind == "!=":
        gone = ("=", key, fact[2])
        return {gone, ("Kv", key)} & about
    return set()


def normal(state):
    """Without entries that known facts make redundant."""
    known = {fact[1] for fact in state if fact[0] in ("K", "=")}
    return frozenset(fact for fact in state if fact[0] in ("K", "=") or fact[1] not in known)


def initial_state(problem: Problem):
    state = frozenset()
    for effect in problem.initial:
        for operation, database, fact, bound in list(updates(problem, state, [effect], {})):
            single = f.Change(operation, database, (fact,))
            state = progress(problem, state, [single], (), bound)
    return state


# ------------------------------------------------------------------------------------------------------- actions
def ground_actions(problem: Problem):
    for action in problem.domain.actions.values():
        for values in product(*(problem.of_type(p.type) for p in action.parameters)):
            yield action, {p.name: v for p, v in zip(action.parameters, values, strict=True)}


def apply(problem: Problem, state, action: Action, binding):
    """The state after an action, or None where it cannot be applied."""
    if not all(holds(problem, state, formula, binding) for formula in action.preconditions):
        return None
    return progress(problem, state, action.effects, action.sense, binding)


def open_facts(problem: Problem, state):
    """Kw entries, and Kv entries of functions with a finite range."""
    return sorted(
        fact
        for fact in state
        if fact[0] == "Kw" or (fact[0] == "Kv" and problem.values_of(fact[1][0]) is not None)
    )


def outcomes(problem: Problem, state, fact):
    """Outcome text to state, for one open fact."""
    rest = frozenset(other for other in state if other[1] != fact[1])
    if fact[0] == "Kw":
        return {"false": rest | {("K", fact[1], False)}, "true": rest | {("K", fact[1], True)}}
    return {
        value: rest | {("=", fact[1], value)}
        for value in problem.values_of(fact[1][0])
        if ("!=", fact[1], value) not in state
    }


# -------------------------------------------------------------------------------------------------- brute force
def solvable(problem: Problem, *, early: bool, limit: int = 20_000) -> bool:
    """Whether a strong acyclic plan exists: the least fixpoint over all reachable knowledge states.

    What is sensed is branched on at once. With `early`, a state that fulfils the goal need not be branched any
    further, whichever fact is branched on first; without, the goal is asked behind all branchings only.
    """
    start = initial_state(problem)
    choices, queue = {}, [start]
    for state in queue:
        if state in choices:
            continue
        choices[state] = list(_choices(problem, state))
        queue.extend(child for choice in choices[state] for child in choice)
        assert len(choices) < limit, "too large for brute force"
    solved = {s for s in choices if goal_holds(problem, s) and (early or not open_facts(problem, s))}
    while True:
        new = {s for s in choices if s not in solved and any(c and set(c) <= solved for c in choices[s])}
        if not new:
            return start in solved
        solved |= new


def _choices(problem: Problem, state):
    facts = open_facts(problem, state)
    if facts:
        for fact in facts:
            yield tuple(outcomes(problem, state, fact).values())
        return
    for action, binding in ground_actions(problem):
        after = apply(problem, state, action, binding)
        if after is not None:
            yield (after,)


def shortest_weak_plan(problem: Problem):
    """How many actions the goal is away if sensing turns out best; None if it is out of reach."""
    layer, seen, length = {initial_state(problem)}, set(), 0
    while layer:
        closed, stack = set(), list(layer)
        while stack:
            state = stack.pop()
            if state in closed:
                continue
            closed.add(state)
            if goal_holds(problem, state):
                return length
            for fact in open_facts(problem, state):
                stack.extend(outcomes(problem, state, fact).values())
        seen |= closed
        settled = [state for state in closed if not open_facts(problem, state)]
        layer = {child for state in settled for choice in _choices(problem, state) for child in choice} - seen
        length += 1
    return None


# ----------------------------------------------------------------------------------------------------- execution
def worlds(problem: Problem, state, only=None):
    """Every world that the knowledge allows: a value for each atom and each term with a finite range.

    With `only`, what is unknown varies for these predicates and functions; all else is as the first world has it.
    """
    domain, ranges = problem.domain, {}
    for name, kinds in domain.predicates.items():
        for arguments in product(*(problem.of_type(kind) for kind in kinds)):
            ranges[(name, *arguments)] = (False, True)
    for name, function in domain.functions.items():
        for arguments in product(*(problem.of_type(kind) for kind in function.arguments)):
            values = problem.values_of(name)
            if values is not None:
                ranges[(name, *arguments)] = values
    for fact in state:
        if fact[0] in ("K", "=") and fact[1] in ranges:
            ranges[fact[1]] = (fact[2],)
    for fact in state:
        if fact[0] == "!=":
            ranges[fact[1]] = tuple(value for value in ranges[fact[1]] if value != fact[2])
    if only is not None:
        ranges = {key: values if key[0] in only else values[:1] for key, values in ranges.items()}
    for values in product(*ranges.values()):
        yield dict(zip(ranges, values, strict=True))


def change_world(problem: Problem, world, state, action: Action, binding):
    """What the action really does: additions to Kf come true, what is set to an unknown value takes it."""
    after = dict(world)
    adds, _ = fired(problem, state, action.effects, (), binding)
    for fact in sorted(adds, key=repr):
        if fact[0] in ("K", "=") and fact[1] in after:
            after[fact[1]] = fact[2]
        elif fact[0] == "!=" and after[fact[1]] == fact[2]:
            after[fact[1]] = next(v for v in problem.values_of(fact[1][0]) if v != fact[2])
    for _, _, fact, bound in updates(problem, state, action.effects, binding):
        if isinstance(fact, f.Comparison) and isinstance(fact.right, f.Application):
            source = ground(fact.right, bound)
            if source in world:
                after[ground(fact.left, bound)] = world[source]
    return after


def text(key) -> str:
    return f"{key[0]}({', '.join(key[1:])})" if key[1:] else key[0]


def execute(problem: Problem, root, world, longest: int = 10_000) -> int:
    """Follows a skeleton in one world with fresh knowledge; asserts every step, returns the number of actions."""
    state, node, steps = initial_state(problem), root, 0
    while not node.is_goal:
        if node.action is not None:
            action, binding = problem.domain.actions[node.action.name], dict(node.action.arguments)
            after = apply(problem, state, action, binding)
            assert after is not None, f"{node.action} cannot be applied"
            world = change_world(problem, world, state, action, binding)
            state, steps = after, steps + 1
            delivered = {text(fact[1]) for fact in state if fact[0] in ("Kw", "Kv")}
            assert set(node.delivers) <= delivered, f"{node.action} does not deliver {node.delivers}"
        if node.on is not None:
            fact = next((fact for fact in open_all(state) if text(fact[1]) == node.on), None)
            assert fact is not None, f"{node.on} is not to be known here"
            truth = world[fact[1]]
            outcome = {False: "false", True: "true"}.get(truth, truth)
            state = outcomes(problem, state, fact)[outcome]
            node = dict(node.outcomes)[outcome]
        else:
            node = node.next
        agrees(state, world)
        assert steps < longest, "the plan runs in circles"
    assert goal_holds(problem, state), "a leaf does not fulfil the goal"
    return steps


def open_all(state):
    return [fact for fact in state if fact[0] in ("Kw", "Kv")]


def agrees(state, world) -> None:
    """Nothing known is wrong."""
    for fact in state:
        if fact[0] == "K":
            assert world[fact[1]] == fact[2], f"wrong knowledge: {fact}"
        elif fact[0] in ("=", "!=") and fact[1] in world:
            assert (world[fact[1]] == fact[2]) == (fact[0] == "="), f"wrong knowledge: {fact}"
