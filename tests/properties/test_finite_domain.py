"""Searches and estimates against the slow and obvious, on random tasks."""

import os

from hypothesis import event, given, settings
from hypothesis import strategies as st

from kabo.finite_domain import (
    CompiledTask,
    Effect,
    FiniteTask,
    Operator,
    RelaxedOperator,
    RelaxedTask,
    StateVariable,
    astar,
    bfws,
    breadth_first,
    validate,
)
from kabo.finite_domain.mutexes import compiled_mutexes, plain_mutexes
from kabo.finite_domain.task import compatible, holds, successor

EXAMPLES = max(30, int(3000 * float(os.environ.get("KABO_PROPERTY_SCALE", "0.1"))))
FACTS = 12


def random_questions(chance):
    """Operators, and three times what is true and wanted. Drawn as `random_task` is, and for the same reason."""
    operators = [
        RelaxedOperator(
            tuple(chance.sample(range(FACTS), chance.choice([0, 1, 1, 2, 3]))),
            tuple(chance.sample(range(FACTS), chance.choice([1, 1, 2]))),
            chance.choice([0, 0, 1, 1, 2, 5, 700, 40_000]),
            chance.randint(-1, 6),
        )
        for _ in range(chance.randint(0, 30))
    ]
    questions = [
        (
            set(chance.sample(range(FACTS), chance.randint(0, 4))),
            chance.sample(range(FACTS), chance.choice([1, 2, 4])),
        )
        for _ in range(3)
    ]
    return operators, questions


def fixpoint(true, operators):
    """All that can become true, one operator at a time."""
    true, grown = set(true), True
    while grown:
        grown = False
        for o in operators:
            if true.issuperset(o.preconditions) and not true.issuperset(o.adds):
                true.update(o.adds)
                grown = True
    return true


@settings(max_examples=EXAMPLES)
@given(st.randoms(use_true_random=True).map(random_questions))
def test_relaxed_plans_reach_the_goal_and_both_twins_find_the_same(drawn):
    operators, questions = drawn
    compiled = RelaxedTask(FACTS, operators, (), engine="compiled")  # nothing of one question stays for the next
    for true, goal in questions:
        ask(compiled, operators, true, tuple(goal))


def ask(compiled, operators, true, goal):
    plain = RelaxedTask(FACTS, operators, goal, engine="python")
    reached = fixpoint(true, operators)
    estimate = plain.evaluate(sorted(true))
    assert {f for f in range(FACTS) if plain.reachable(sorted(true))[f]} == reached
    assert (estimate.value is None) == (not reached.issuperset(goal))
    event("unreachable" if estimate.value is None else f"{len(estimate.plan_facts)} facts to make")
    assert compiled.evaluate(sorted(true), goal) == estimate
    assert compiled.evaluate(sum(1 << f for f in true), goal) == estimate
    if estimate.value is not None:
        judge(estimate, operators, true, goal)


def judge(estimate, operators, true, goal):
    """The facts of the plan can be made from each other, and with axioms reach the goal; the preferred can go."""
    axioms = [o for o in operators if o.cost == 0 and o.owner < 0]
    now = fixpoint(true, axioms)
    inside = now | set(estimate.plan_facts)
    assert not now & set(estimate.plan_facts)
    useful = [o for o in operators if inside.issuperset(o.preconditions)]
    limited = [
        RelaxedOperator(o.preconditions, tuple(inside.intersection(o.adds)), o.cost, o.owner) for o in useful
    ]
    assert fixpoint(true, limited) == inside
    assert inside.issuperset(goal)
    for owner in estimate.preferred:
        assert any(o.owner == owner and now.issuperset(o.preconditions) for o in operators)
    needed = fixpoint(true, [o for o in operators if o.cost == 0])
    assert estimate.value > 0 or needed.issuperset(goal)


def random_task(chance):
    """Variables whose values operators set on conditions; what could set one variable twice at once is left out.

    Not drawn one choice at a time: hypothesis likes small choices, and tasks of these take no action at all.
    """
    sizes = [chance.choice([1, 2, 3, 3, 4]) for _ in range(chance.randint(2, 5))]

    def conditions(count):
        asked = chance.sample(range(len(sizes)), min(count, len(sizes)))
        return tuple(
            (v, tuple(chance.sample(range(sizes[v]), min(sizes[v], chance.choice([1, 1, 1, 2]))))) for v in asked
        )

    def operator():
        needed, effects = conditions(chance.choice([0, 1, 1, 2])), []
        for v in chance.choices(range(len(sizes)), k=chance.choice([1, 2, 3])):
            effect = Effect(conditions(chance.choice([0, 0, 1, 1, 2])), v, chance.randrange(sizes[v]))
            if all(
                e.variable != v
                or e.value == effect.value
                or bool(e.conditions) != bool(effect.conditions)
                or not compatible(needed + e.conditions + effect.conditions)
                for e in effects
            ):
                effects.append(effect)
        return Operator("o", needed, tuple(effects), chance.choice([0, 1, 1, 1, 2, 5]))

    operators = tuple(operator() for _ in range(chance.randint(3, 9)))
    initial = tuple(chance.randrange(n) for n in sizes)
    there = wandered(initial, operators, chance) if chance.random() < 0.8 else initial
    goal = tuple(
        (v, tuple({there[v] if chance.random() < 0.9 else chance.randrange(n), *chance.sample(range(n), n > 3)}))
        for v, n in enumerate(sizes)
        if chance.random() < 0.8
    )
    return FiniteTask(tuple(StateVariable(f"v{v}", n) for v, n in enumerate(sizes)), initial, operators, goal)


def wandered(state, operators, chance):
    """Where a random walk ends that goes to new states only."""
    seen = {state}
    for _ in range(12):
        ways = [successor(o, state) for o in operators if holds(o.preconditions, state)]
        ways = [after for after in ways if after not in seen]
        if not ways:
            return state
        state = chance.choice(ways)
        seen.add(state)
    return state


def tasks():
    return st.randoms(use_true_random=True).map(random_task)


def brute_force(task, start, forbidden=()):
    """Of all states that can be reached the fewest actions and the least cost."""
    steps, costs = {start: 0}, {start: 0}
    for table, price in ((steps, lambda o: 1), (costs, lambda o: o.cost)):
        changed = True
        while changed:
            changed = False
            for state in list(table):
                for i, o in enumerate(task.operators):
                    if i in forbidden or not holds(o.preconditions, state):
                        continue
                    after, total = successor(o, state), table[state] + price(o)
                    if total < table.get(after, 1 << 30):
                        table[after], changed = total, True
    best = [(steps[s], costs[s]) for s in steps if holds(task.goal, s)]
    return (min(b[0] for b in best), min(b[1] for b in best)) if best else None


def executes(task, start, plan, forbidden=()):
    """Whether the plan leads from the start to the goal."""
    state = start
    for i in plan:
        if i in forbidden or not holds(task.operators[i].preconditions, state):
            return False
        state = successor(task.operators[i], state)
    return holds(task.goal, state)


@settings(max_examples=EXAMPLES)
@given(tasks(), st.data())
def test_breadth_first_agrees_with_brute_force_in_both_twins(task, data):
    assert not validate(task)
    start = data.draw(st.sampled_from([task.initial, tuple(v.size - 1 for v in task.variables)]))
    forbidden = data.draw(st.sets(st.integers(0, 8), max_size=1)) & set(range(len(task.operators)))
    banned = [int(i in forbidden) for i in range(len(task.operators))]
    compiled, best = CompiledTask(task), brute_force(task, start, forbidden)
    plain = breadth_first(compiled, start=start, forbidden=banned)
    assert breadth_first(compiled, start=start, forbidden=banned, plain_work=0) == plain
    event("unsolvable" if best is None else f"{best[0]} actions")
    assert plain.status == ("unsolvable" if best is None else "solved")
    if best is not None:
        assert len(plain.plan) == best[0]
        assert executes(task, start, plain.plan, forbidden)
        assert plain.cost == sum(task.operators[o].cost for o in plain.plan)


@settings(max_examples=EXAMPLES)
@given(tasks(), st.data())
def test_the_novelty_search_solves_what_can_be_solved_and_both_twins_alike(task, data):
    start = data.draw(st.sampled_from([task.initial, tuple(v.size - 1 for v in task.variables)]))
    forbidden = data.draw(st.sets(st.integers(0, 8), max_size=1)) & set(range(len(task.operators)))
    banned = [int(i in forbidden) for i in range(len(task.operators))]
    compiled, best = CompiledTask(task), brute_force(task, start, forbidden)
    plain = bfws(compiled, start=start, forbidden=banned)
    assert bfws(compiled, start=start, forbidden=banned, plain_work=0) == plain
    assert plain.status == ("unsolvable" if best is None else "solved")
    if best is not None:
        event(f"{len(plain.plan) - best[0]} actions too many")
        assert executes(task, start, plain.plan, forbidden)


@settings(max_examples=EXAMPLES)
@given(tasks())
def test_pairs_held_impossible_show_in_no_state_that_can_be_reached(task):
    compiled = CompiledTask(task)
    start = compiled.relaxed.of(task.initial)
    plain = plain_mutexes(compiled.fact_task, start)
    kernel = compiled_mutexes(compiled.fact_task, start)  # may hold a few pairs more possible, never fewer
    assert all(few & ~many == 0 for few, many in zip(plain.together, kernel.together, strict=True))
    seen = [task.initial]
    for state in seen:
        facts = compiled.relaxed.of(state)
        assert plain.allow(facts)
        for o in task.operators:
            if holds(o.preconditions, state) and successor(o, state) not in seen:
                seen.append(successor(o, state))
    pairs = {(f, g) for state in seen for f in compiled.relaxed.of(state) for g in compiled.relaxed.of(state)}
    held = sum(row.bit_count() for row in plain.together)
    event(f"{held - len(pairs)} pairs held possible too many")


@settings(max_examples=EXAMPLES)
@given(tasks(), st.data())
def test_astar_finds_the_least_cost_and_its_bound_is_never_above_it(task, data):
    start = data.draw(st.sampled_from([task.initial, tuple(v.size - 1 for v in task.variables)]))
    forbidden = data.draw(st.sets(st.integers(0, 8), max_size=1)) & set(range(len(task.operators)))
    banned = [int(i in forbidden) for i in range(len(task.operators))]
    compiled, best = CompiledTask(task), brute_force(task, start, forbidden)
    for work in (0, 1 << 30):
        result = astar(compiled, start=start, forbidden=banned, plain_work=work)
        assert result.status == ("unsolvable" if best is None else "solved")
        if best is not None:
            assert result.cost == best[1] == sum(task.operators[o].cost for o in result.plan)
            assert executes(task, start, result.plan, forbidden)
            if work == 0 and result.plan:
                assert result.initial_estimate <= best[1]
                event(f"cost {best[1]}, {best[1] - result.initial_estimate} more than the bound")
