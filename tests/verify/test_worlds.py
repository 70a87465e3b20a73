"""Running plans in worlds: how many there are, which of them fail, and what actions leave open."""

import json
from itertools import product

import pytest

from kabo.plan import Node, PlanBuilder
from kabo.verify import validate_worlds, verify_plan
from kabo.verify.knowledge.replay.interpreter import Interpreter
from kabo.verify.knowledge.worlds.streams import Stream
from tests.linked_worlds import all_worlds, linked_groups
from tests.verify.hand_made import GOAL, do, look, plan_of, problem_of

LAMPS = """types: [lamp]
predicates: {{on: [lamp], broken: [lamp], checked: []}}
functions:
  colour: {{arguments: [lamp], value: [red, green, blue]}}
{rules}actions:
  look:
    parameters: {{l: lamp}}
    sense: on(l)
  see_colour:
    parameters: {{l: lamp}}
    sense: colour(l)
  press:
    parameters: {{l: lamp}}
    effects:
      - K(on(l)) => add(Kf, not on(l))
      - K(not on(l)) => add(Kf, on(l))
  switch_on:
    parameters: {{l: lamp}}
    effects:
      - when not broken(l) then on(l)
  shake:
    parameters: {{l: lamp}}
    effects:
      - del(Kf, on(l))
  exchange:
    parameters: {{l: lamp}}
    effects:
      - add(Kf, not broken(l))
  repaint:
    parameters: {{l: lamp}}
    effects:
      - add(Kf, colour(l) != red)
"""


@pytest.fixture
def lamps(tmp_path):
    def load(goal: str, *initial: str, objects: str = "a, b", rules: str = ""):
        lines = "".join(f"  - {line}\n" for line in initial)
        start = f"initial:\n{lines}" if initial else ""
        text = LAMPS.format(rules=f"update_rules:\n  - {rules}\n" if rules else "")
        return problem_of(tmp_path, text, f"objects: {{lamp: [{objects}]}}\n{start}goal: {goal}\n")

    return load


def run(problem, tree, **options):
    return validate_worlds(problem, plan_of(problem, tree), **options)


def pressed(otherwise=GOAL):
    return look("look", "on(a)", {"true": otherwise, "false": do("press", otherwise, l="a")}, l="a")


def test_all_worlds_are_tried_and_lengths_are_counted(lamps):
    report = run(lamps("K(on(a))"), pressed())
    assert (report.worlds, report.exhaustive, report.findings) == (2, True, ())
    assert (report.shortest, report.mean, report.longest) == (1, 1.5, 2)
    assert str(report) == "2 worlds, all of them: every one reaches the goal in 1 to 2 actions (mean 1.50)"
    both = look("look", "on(b)", {"true": GOAL, "false": do("press", GOAL, l="b")}, l="b")
    assert run(lamps("K(on(a)) and K(on(b))"), pressed(both)).worlds == 4


def test_the_world_that_shows_a_fault_is_named(lamps):
    wrong = look("look", "on(a)", {"true": GOAL, "false": GOAL}, l="a")
    report = run(lamps("K(on(a))"), wrong)
    assert [finding.node for finding in report.findings] == ["n1"]
    assert "[world: not on(a)]" in report.findings[0].message
    missing = look("look", "on(a)", {"true": GOAL}, l="a")
    text = str(run(lamps("K(on(a))"), missing).findings[0])
    assert text == "n0: no branch for on(a) = false, which is the case [world: not on(a)]"
    assert str(run(lamps("K(on(a))"), missing)) == "2 worlds, all of them: not every one reaches the goal"


def test_what_an_action_may_change_either_way_is_tried_either_way(lamps):
    looked = look("look", "on(a)", {"true": GOAL, "false": do("press", GOAL, l="a")}, l="a")
    problem = lamps("K(on(a))", "add(Kf, on(a))")
    report = run(problem, do("shake", looked, l="a"))
    assert (report.worlds, report.findings, report.shortest, report.longest) == (1, (), 2, 3)
    text = str(run(problem, do("shake", GOAL, l="a")).findings[0])
    assert "the goal claims to know what is not so" in text
    forgot = run(problem, do("shake", look("look", "on(a)", {"true": GOAL}, l="a"), l="a"))
    assert "[left open by actions: not on(a)]" in forgot.findings[0].message


def test_a_value_that_is_changed_may_become_any_other(lamps):
    problem = lamps("Kv(colour(a))", "add(Kf, colour(a) = red)")
    seen = look("see_colour", "colour(a)", {"green": GOAL, "blue": GOAL}, l="a")
    assert run(problem, do("repaint", seen, l="a")).findings == ()
    one = look("see_colour", "colour(a)", {"green": GOAL}, l="a")
    assert "no branch for colour(a) = blue" in str(run(problem, do("repaint", one, l="a")).findings)


def test_world_effects_act_on_what_is_true(lamps):
    problem = lamps("K(on(a))", "add(Kf, not on(a))")
    assert run(problem, do("exchange", do("switch_on", GOAL, l="a"), l="a")).findings == ()
    text = str(run(problem, do("switch_on", GOAL, l="a")).findings[0])
    assert "n1: the goal claims to know what is not so" in text and "[world: broken(a)]" in text


def test_update_rules_rule_worlds_out(lamps):
    rule = "forall(lamp l) (K(broken(l)) => add(Kf, not on(l)))"
    problem = lamps("K(not broken(a)) or K(not on(a))", rules=rule)
    report = run(problem, look("look", "on(a)", {"true": GOAL, "false": GOAL}, l="a"))
    assert (report.worlds, report.findings) == (3, ()), "a lamp that is broken and on is impossible"


def test_more_worlds_than_the_limit_are_sampled_and_the_same_ones_with_the_same_seed(lamps):
    names = ", ".join(f"l{i}" for i in range(14))
    problem = lamps("forall(lamp l) K(on(l))", objects=names)
    builder = PlanBuilder()
    last = builder.goal()
    for i in range(14):
        lamp = {"l": f"l{i}"}
        press = builder.add(Node("action", "press", lamp, next=last))
        last = builder.add(Node("sense", "look", lamp, on=f"on(l{i})", branches={"true": last, "false": press}))
    options = {"search": "by hand", "seed": 0, "epsilon": None, "geometry": "none"}
    plan = builder.build(last, problem="one", files=problem.files, options=options)
    first, again = validate_worlds(problem, plan, samples=40), validate_worlds(problem, plan, samples=40)
    assert first == again and (first.worlds, first.exhaustive, first.findings) == (40, False, ())
    assert 14 < first.shortest < first.mean < first.longest < 28
    assert validate_worlds(problem, plan, samples=40, seed=1) != first
    everything = validate_worlds(problem, plan, limit=2**14)
    assert (everything.worlds, everything.exhaustive, everything.mean) == (2**14, True, 21.0)


def test_the_report_of_verification_tells_of_worlds(lamps):
    problem = lamps("K(on(a))")
    report = verify_plan(problem, plan_of(problem, pressed()), knowledge_only=True)
    assert "worlds: 2 worlds, all of them: every one reaches the goal in 1 to 2 actions" in str(report)
    assert json.loads(json.dumps(report.to_dict()))["worlds"] == {
        "worlds": 2, "exhaustive": True, "shortest": 1, "mean": 1.5, "longest": 2, "ruled_out": 0,
    }  # fmt: skip
    unknown = verify_plan(problem, plan_of(problem, do("fly", GOAL)))
    assert unknown.worlds is None and 'unknown action "fly"' in str(unknown)


def test_a_plan_in_a_circle_or_with_wrong_calls_is_not_run(lamps):
    problem = lamps("K(on(a))")
    plan = plan_of(problem, do("press", GOAL, l="a"))
    circle = {**plan.nodes, "n0": Node("action", "press", {"l": "a"}, next="n0")}
    report = validate_worlds(problem, type(plan)("one", plan.files, plan.options, "n0", circle))
    assert "circle" in str(report.findings) and report.worlds == 0


# ----------------------------------------------------------------------------------------------- initial worlds
def groups_of(problem):
    interpreter = Interpreter(problem)
    symbols = [("on", (lamp,)) for lamp in problem.objects] + [("colour", (lamp,)) for lamp in problem.objects]
    return linked_groups(problem, interpreter.initial(), interpreter.rules, symbols)


def test_all_worlds_are_those_that_brute_force_finds(lamps):
    initial = (
        "add(Kx, on(a), on(b), colour(a) = red)",
        "add(Kor, not on(b), colour(b) = green)",
        "add(Kf, colour(b) != red)",
    )
    found = all_worlds(groups_of(lamps("true", *initial)), 1000)
    values = (False, True)
    colours = ("red", "green", "blue")
    expected = {
        (a, b, first, second)
        for a, b, first, second in product(values, values, colours, colours[1:])
        if [a, b, first == "red"].count(True) == 1 and (not b or second == "green")
    }
    names = [("on", ("a",)), ("on", ("b",)), ("colour", ("a",)), ("colour", ("b",))]
    assert {tuple(world[name] for name in names) for world in found} == expected
    assert len(found) == len(expected), "none stands there twice"


def test_samples_agree_with_the_entries_and_are_all_different(lamps):
    names = [f"l{i}" for i in range(30)]
    exclusive = [f"add(Kx, {', '.join(f'on({n})' for n in names[i : i + 5])})" for i in range(0, 30, 5)]
    problem = lamps("true", *exclusive, objects=", ".join(names))
    possible = possible_worlds(groups_of(problem), 3000, 200, 7)
    assert not possible.exhaustive and len(possible.worlds) == 200
    assert len({tuple(world.values()) for world in possible.worlds}) == 200
    for world in possible.worlds:
        assert all(sum(world["on", (n,)] for n in names[i : i + 5]) == 1 for i in range(0, 30, 5))


def test_one_long_exclusive_set_is_sampled_evenly_enough(lamps):
    names = [f"l{i}" for i in range(12)]
    problem = lamps("true", f"add(Kx, {', '.join(f'on({n})' for n in names)})", objects=", ".join(names))
    group = next(group for group in groups_of(problem) if len(group.symbols) == 12)
    drawn = [group.sample(Stream(0, index)) for index in range(600)]
    counts = [sum(world["on", (name,)] for world in drawn) for name in names]
    assert sum(counts) == 600 and min(counts) > 25 and max(counts) < 85
