"""Worlds judge as brute force does: random contingent problems, plans as they are found, and plans that are tampered with.

`tests/oracles_belief.py` writes every world down and walks the plan as a tree; kabo's worlds leave open what nobody looks
at, share nodes and forget. Besides, whatever kabo's own inference finds right, somebody who reasons perfectly does, too.
"""

import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from random import Random

from kabo.language import load_problem
from kabo.language.problem import Problem
from kabo.plan import Plan
from kabo.planner.solve import solve
from kabo.verify.knowledge.arguments import check_calls
from kabo.verify.knowledge.replay import replay
from kabo.verify.knowledge.replay.draft import ContradictionError
from kabo.verify.knowledge.replay.interpreter import Interpreter
from kabo.verify.knowledge.worlds import CannotJudgeError, judge_in_worlds
from kabo.verify.structure import check_structure
from tests.conftest import PROPERTY_SCALE
from tests.oracles_belief import Unjudged, accepts
from tests.oracles_worlds import find_plan, ground_actions, has_world
from tests.random_knowledge import random_problem

SEEDS = range(max(150, round(2500 * PROPERTY_SCALE)))
TAMPERED = 6  # plans for one problem


def loaded(seed: int) -> Problem:
    domain, problem = random_problem(seed)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "domain.yaml").write_text(domain)
        (Path(folder) / "p.yaml").write_text(problem)
        return replace(load_problem(Path(folder) / "p.yaml"), files={})


def tampered(random: Random, plan: Plan, actions: list) -> Plan | None:
    """The plan with one change: another action, another successor, a branch less, two exchanged, two the same."""
    nodes = dict(plan.nodes)
    inner = [name for name, node in nodes.items() if node.kind != "goal"]
    if not inner:
        return None
    name = random.choice(inner)
    node, branches = nodes[name], nodes[name].branches
    kinds = ["successor", *["action"] * 2 * (node.action is not None), *["less", "swap", "same"] * bool(branches)]
    match random.choice(kinds):
        case "action":
            action, arguments = random.choice(actions)
            nodes[name] = replace(node, action=action.action.name, arguments=arguments)
        case "successor" if node.next is not None:
            nodes[name] = replace(node, next=random.choice(sorted(nodes)))
        case "successor":
            changed = {**branches, random.choice(sorted(branches)): random.choice(sorted(nodes))}
            nodes[name] = replace(node, branches=changed)
        case "less":
            gone = random.choice(sorted(branches))
            nodes[name] = replace(node, branches={o: s for o, s in branches.items() if o != gone})
        case "swap":
            nodes[name] = replace(node, branches=dict(zip(branches, reversed(branches.values()), strict=True)))
        case "same":
            nodes[name] = replace(node, branches=dict.fromkeys(branches, next(iter(branches.values()))))
    changed_plan = replace(plan, nodes=nodes)
    reached = set(check_structure(changed_plan)[0])  # empty if it runs in a circle
    if not reached or any(not n.successors and n.kind != "goal" for n in nodes.values()):
        return None
    return replace(changed_plan, nodes={n: node for n, node in nodes.items() if n in reached})


def plans_for(seed: int, problem: Problem) -> Iterator[Plan]:
    """Right plans, and plans that are tampered with once or more."""
    try:
        found = find_plan(problem, 300) if has_world(problem) else None
        actions = ground_actions(Interpreter(problem))
    except ContradictionError:
        return
    if found is None:
        return
    random, plans = Random(seed), [replace(found, files={})]
    kabos = solve(problem, max_expansions=300).plan
    if kabos is not None:
        plans.append(kabos)
    for _ in range(TAMPERED):
        spoiled = tampered(random, random.choice(plans), actions)
        if spoiled is not None:
            plans.append(spoiled)
    yield from plans


def test_worlds_and_brute_force_agree_on_every_plan():
    told: Counter[str] = Counter()
    for seed in SEEDS:
        problem = loaded(seed)
        for number, plan in enumerate(plans_for(seed, problem)):
            order = check_structure(plan)[0]
            assert not check_calls(plan, order, problem)
            inferred = not replay(plan, problem, order).findings
            try:
                report = judge_in_worlds(problem, plan, order).report
            except CannotJudgeError:
                told["not judged by worlds"] += 1
                continue
            right = not report.findings
            assert right or not inferred, f"problem {seed}, plan {number}: inference accepts, worlds say {report}"
            try:
                expected = accepts(problem, plan)
            except Unjudged:
                told["not judged by brute force"] += 1
                continue
            assert right is expected, (
                f"problem {seed}, plan {number}: brute force says {expected}, worlds {report}"
            )
            told[f"right: {right}"] += 1
            told["right, but more than inference finds"] += right and not inferred
    print(dict(told))
    both = told["right: True"] + told["right: False"]
    assert both >= 2 * len(SEEDS) * 0.5 and min(told["right: True"], told["right: False"]) > both / 5, dict(told)
    assert told["not judged by brute force"] < both / 20, dict(told)
