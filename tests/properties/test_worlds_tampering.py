"""Whatever is changed in a valid plan: if somebody who only executes it finds it wrong, the verifier says so.

The judge here knows no knowledge: it executes a plan in true worlds, and calls it wrong if a branch is missing, a
positive precondition claims what is false, or the goal does.
"""

import os
import tempfile
from dataclasses import replace
from functools import cache
from itertools import product
from pathlib import Path

from hypothesis import assume, event, given, settings
from hypothesis import strategies as st

from kabo.language import formulas as f
from kabo.language import load_problem
from kabo.language.problem import Problem
from kabo.plan import Plan
from kabo.verify import verify_plan
from kabo.verify.knowledge.replay.interpreter import Interpreter
from kabo.verify.knowledge.replay.mutable_knowledge import ContradictionError
from kabo.verify.structure import check_structure
from tests.support.oracles_worlds import find_plan, ground_actions, has_world
from tests.support.random_knowledge import random_problem

SCALE = float(os.environ.get("KABO_PROPERTY_SCALE", "0.1"))
EXAMPLES = settings(max_examples=max(60, round(2000 * SCALE)))


@cache
def solved(seed: int) -> tuple[Problem, Plan] | None:
    """A random problem and a plan for it with some nodes; None if there is none."""
    domain, problem = random_problem(seed)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "domain.yaml").write_text(domain)
        (Path(folder) / "p.yaml").write_text(problem)
        loaded = load_problem(Path(folder) / "p.yaml")
    try:
        plan = find_plan(loaded, 300) if has_world(loaded) else None
    except ContradictionError:
        return None
    return None if plan is None or len(plan.nodes) < 3 else (replace_path(loaded), replace(plan, files={}))


def replace_path(problem: Problem) -> Problem:
    """Without the files, which are gone."""
    return replace(problem, files={})


PROBLEMS = [seed for seed in range(round(400 * max(SCALE, 0.5))) if solved(seed) is not None]


# ------------------------------------------------------------------------------------------------------ the judge
class Wrong(Exception):
    pass


def ground(thing, binding):
    return (
        thing.predicate if isinstance(thing, f.Atom) else thing.function,
        *(value(a, binding) for a in thing.arguments),
    )


def value(term, binding):
    return binding.get(term.name, term.name) if isinstance(term, f.Constant | f.Variable) else term.value


def true(claim, world, binding):
    """Whether a literal or comparison is true; a run-time variable stands for f."""

    def read(term):
        if isinstance(term, f.Application):
            return world[ground(term, binding)]
        named = value(term, binding)
        return named if isinstance(named, str) else world[("f",)]

    if isinstance(claim, f.Literal):
        return world[ground(claim.atom, binding)] is claim.positive
    return (read(claim.left) == read(claim.right)) is (claim.operator == "=")


def may_hold(formula, problem, world, binding):
    """False only where a claim to know is false."""
    match formula:
        case f.Know(claim):
            return true(claim, world, binding)
        case f.And(parts):
            return all(may_hold(part, problem, world, binding) for part in parts)
        case f.Or(parts):
            return any(may_hold(part, problem, world, binding) for part in parts)
        case f.Forall(variables, body):
            names = [variable.name for variable in variables]
            every = product(*(problem.of_type(variable.type) for variable in variables))
            return all(
                may_hold(body, problem, world, {**binding, **dict(zip(names, v, strict=True))}) for v in every
            )
    return True


def deterministic(problem: Problem) -> bool:
    """Whether this judge can execute it: only plain additions of literals and f = v, and `when` effects."""
    if problem.domain.update_rules:
        return False
    effects = [effect for action in problem.domain.actions.values() for effect in action.effects]
    return all(map(executable, effects)) and all(isinstance(e, f.Change) for e in problem.initial)


def executable(effect) -> bool:
    if isinstance(effect, f.WorldEffect):
        return True
    if not isinstance(effect, f.Change) or effect.operation != "add":
        return isinstance(effect, f.Change) and effect.database == "Kw"
    if effect.database != "Kf":
        return effect.database in ("Kw", "Kv")
    return all(not isinstance(fact, f.Comparison) or fact.operator == "=" for fact in effect.facts)


def executed(problem: Problem, plan: Plan, world: dict) -> None:
    """Follows the plan; raises Wrong."""
    name = plan.root
    while True:
        node = plan.nodes[name]
        if node.kind == "goal":
            if not all(may_hold(part, problem, world, {}) for part in problem.goal):
                raise Wrong("goal")
            return
        if node.action is not None:
            action, binding = problem.domain.actions[node.action], dict(node.arguments)
            if not all(may_hold(part, problem, world, binding) for part in action.preconditions):
                raise Wrong("precondition")
            world = changed(action.effects, world, binding)
        if node.on is None:
            name = node.next
            continue
        outcome = sensed(node.on, world)
        if outcome not in node.branches:
            raise Wrong("branch")
        name = node.branches[outcome]


def changed(effects, world: dict, binding) -> dict:
    after, pulls = dict(world), {}
    for effect in effects:
        if isinstance(effect, f.WorldEffect) and all(true(claim, world, binding) for claim in effect.conditions):
            for outcome in effect.outcomes:
                pulls.setdefault(ground(outcome.atom, binding), set()).add(outcome.positive)
    for atom, ways in pulls.items():
        assume(len(ways) == 1)  # pulled both ways: anything may happen, which this judge does not follow
        after[atom] = ways.pop()
    for effect in effects:
        if isinstance(effect, f.Change) and effect.database == "Kf":
            for fact in effect.facts:
                if isinstance(fact, f.Literal):
                    after[ground(fact.atom, binding)] = fact.positive
                else:
                    right = value(fact.right, binding)
                    after[ground(fact.left, binding)] = right if isinstance(right, str) else world[("f",)]
    return after


def sensed(on: str, world: dict) -> str:
    parts = on.split(" and ")
    values = [world[read(part.removeprefix("not "))] for part in parts]
    if len(parts) == 1 and not isinstance(values[0], bool):
        return values[0]
    return "true" if all(v is not p.startswith("not ") for v, p in zip(values, parts, strict=True)) else "false"


def read(text: str):
    name, _, arguments = text.partition("(")
    return (name, *arguments.rstrip(")").split(", ")) if arguments else (name,)


def worlds(problem: Problem):
    """Every assignment that the initial facts allow, straight from the file's own effects."""
    symbols = [("p", "x"), ("p", "y"), ("q",), ("r",), ("s",)]
    ranges = [(False, True)] * 5
    for name in problem.domain.functions:
        symbols.append((name,))
        ranges.append(problem.values_of(name))
    for values in product(*ranges):
        world = dict(zip(symbols, values, strict=True))
        if all(allowed(effect, problem, world) for effect in problem.initial):
            yield world


def allowed(effect: f.Change, problem: Problem, world: dict) -> bool:
    if effect.database in ("Kw", "Kv"):
        return True
    if effect.database == "LCW":
        return True  # more worlds than there are: left to `assume`
    truths = [true(fact, world, {}) for fact in effect.facts]
    return {"Kf": all(truths), "Kx": sum(truths) == 1, "Kor": any(truths)}[effect.database]


def first_fault(problem: Problem, plan: Plan) -> str | None:
    for world in worlds(problem):
        try:
            executed(problem, plan, world)
        except Wrong as wrong:
            return str(wrong)
    return None


# ------------------------------------------------------------------------------------------------------ tampering
@st.composite
def spoiled(draw, problem: Problem, plan: Plan) -> Plan:
    """The plan with one change: a branch less, two exchanged, another action, another successor."""
    nodes = dict(plan.nodes)
    name = draw(st.sampled_from([n for n, node in nodes.items() if node.kind != "goal"]))
    node = nodes[name]
    kinds = ["successor"] + ["action"] * (node.action is not None) + ["less", "swap", "cut"] * bool(node.branches)
    kind = draw(st.sampled_from(kinds))
    event(kind)
    if kind == "action":
        actions = ground_actions(Interpreter(problem))
        action, arguments = draw(st.sampled_from(actions))
        nodes[name] = replace(node, action=action.action.name, arguments=arguments)
    elif kind == "successor":
        target = draw(st.sampled_from(sorted(nodes)))
        if node.next is not None:
            nodes[name] = replace(node, next=target)
        else:
            outcome = draw(st.sampled_from(sorted(node.branches)))
            nodes[name] = replace(node, branches={**node.branches, outcome: target})
    elif kind == "less":
        outcome = draw(st.sampled_from(sorted(node.branches)))
        assume(len(node.branches) > 1)
        nodes[name] = replace(node, branches={o: s for o, s in node.branches.items() if o != outcome})
    elif kind == "swap":
        outcomes = list(node.branches)
        nodes[name] = replace(node, branches=dict(zip(outcomes, reversed(node.branches.values()), strict=True)))
    else:
        nodes[name] = replace(node, branches=dict.fromkeys(node.branches, next(iter(node.branches.values()))))
    changed_plan = replace(plan, nodes=nodes)
    reached = set(check_structure(changed_plan)[0])
    return replace(changed_plan, nodes={n: node for n, node in nodes.items() if n in reached} or nodes)


def has_closed_world(problem: Problem) -> bool:
    return any(effect.database == "LCW" for effect in problem.initial)


@EXAMPLES
@given(data=st.data(), seed=st.sampled_from(PROBLEMS))
def test_what_execution_finds_wrong_is_found(data, seed):
    problem, plan = solved(seed)
    assume(deterministic(problem) and not has_closed_world(problem))
    assert first_fault(problem, plan) is None and verify_plan(problem, plan).ok
    other = data.draw(spoiled(problem, plan))
    report = verify_plan(problem, other)
    if not check_structure(other)[0]:
        event("circle")
        assert not report.ok
        return
    fault = first_fault(problem, other)
    event(f"execution: {fault}, verifier: {'right' if report.ok else 'wrong'}")
    assert fault is None or not report.ok, f"{fault} is not found\n{other}"
    if fault == "branch" and report.worlds is not None:
        assert any("no branch" in finding.message for finding in report.worlds.findings)


@EXAMPLES
@given(seed=st.integers(0, 10_000))
def test_plans_that_the_oracle_finds_are_right_in_every_world(seed):
    """The interpreter of knowledge against the one of worlds: what follows from what is known is true."""
    found = solved(seed)
    if found is None:
        return
    report = verify_plan(*found)
    event(f"judged by {report.judge}")
    assert report.ok, str(report)
