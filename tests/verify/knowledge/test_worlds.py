"""Running plans in worlds: how many there are, which of them fail, and what actions leave open."""

import json
from itertools import product

import pytest

from kabo.plan import Node, PlanBuilder
from kabo.verify import validate_worlds, verify_plan
from kabo.verify.knowledge.worlds.initial import start_of
from kabo.verify.knowledge.worlds.world import every
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
  match:
    parameters: {{l: lamp, m: lamp}}
    effects:
      - add(Kf, colour(l) = colour(m))
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
    assert text == "n0: no branch for on(a) = false, which is possible [world: not on(a)]"
    assert str(run(lamps("K(on(a))"), missing)) == "2 worlds, all of them: not every one reaches the goal"


def test_what_an_action_may_change_either_way_is_tried_either_way(lamps):
    looked = look("look", "on(a)", {"true": GOAL, "false": do("press", GOAL, l="a")}, l="a")
    problem = lamps("K(on(a))", "add(Kf, on(a))")
    report = run(problem, do("shake", looked, l="a"))
    assert (report.worlds, report.findings, report.shortest, report.longest) == (1, (), 2, 3)
    text = str(run(problem, do("shake", GOAL, l="a")).findings[0])
    assert "the goal does not hold at this leaf" in text and "[left open by actions: not on(a)]" in text
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
    assert "n1: the goal does not hold at this leaf" in text and "[world: broken(a)]" in text


def test_what_worlds_cannot_judge_is_replayed_and_the_report_says_why(lamps):
    rule = "forall(lamp l) (K(broken(l)) => add(Kf, not on(l)))"
    problem = lamps("Kw(on(a))", rules=rule)
    tree = look("look", "on(a)", {"true": GOAL, "false": GOAL}, l="a")
    report = verify_plan(problem, plan_of(problem, tree), knowledge_only=True)
    assert report.ok and report.worlds is None and report.judge == "replay"
    assert "judged by replay of what kabo infers, because the domain has update rules" in str(report)
    said = json.loads(json.dumps(report.to_dict()))["knowledge"]
    assert said["judge"] == "replay" and said["why_replay"].startswith("the domain has update rules")
    alone = run(problem, tree)
    assert not alone.exhaustive and "worlds cannot judge this plan: the domain has" in str(alone.findings[0])


def lamps_one_after_the_other(problem, names):
    builder = PlanBuilder()
    last = builder.goal()
    for name in names:
        press = builder.add(Node("action", "press", {"l": name}, next=last))
        branches = {"true": last, "false": press}
        last = builder.add(Node("sense", "look", {"l": name}, on=f"on({name})", branches=branches))
    options = {"search": "by hand", "seed": 0, "epsilon": None, "geometry": "none"}
    return builder.build(last, problem="one", files=problem.files, options=options)


def test_what_branches_share_costs_its_nodes_however_many_worlds_there_are(lamps):
    names = [f"l{i}" for i in range(40)]
    problem = lamps("forall(lamp l) K(on(l))", objects=", ".join(names))
    plan = lamps_one_after_the_other(problem, names)
    report = verify_plan(problem, plan)
    assert report.ok and report.states == 81, (
        "a node is looked at once, for what its rest does not ask for is forgotten"
    )
    assert (report.worlds.worlds, report.worlds.exhaustive, report.worlds.mean) == (2**40, True, 60.0)
    assert (report.worlds.shortest, report.worlds.longest) == (40, 80)
    assert "about 1.1e+12 worlds, all of them" in str(report)


def test_worlds_give_up_at_their_limit_and_the_replay_takes_over(lamps):
    names = [f"l{i}" for i in range(14)]
    problem = lamps("forall(lamp l) K(on(l))", objects=", ".join(names))
    plan = lamps_one_after_the_other(problem, names)
    assert run_plan(problem, plan).worlds == 2**14
    assert "too many worlds arise along it" in str(run_plan(problem, plan, limit=20).findings[0])
    linked = lamps(
        "K(on(l0)) or not K(on(l0))", f"add(Kor, {', '.join(f'on({n})' for n in names)})", objects=", ".join(names)
    )
    report = verify_plan(linked, plan_of(linked, GOAL))
    assert report.ok and "combinations of linked unknowns" in str(report.why_replay)


def test_two_terms_are_known_to_be_equal_whatever_they_are(lamps):
    same = lamps("K(colour(a) = colour(b))")
    report = verify_plan(same, plan_of(same, do("match", GOAL, l="a", m="b")))
    assert report.ok and (report.judge, report.worlds.worlds) == ("worlds", 3)
    text = str(verify_plan(same, plan_of(same, do("press", GOAL, l="a"))))
    assert "the goal does not hold" in text
    differ = lamps("not K(colour(a) = colour(b))")
    assert not run(differ, do("match", GOAL, l="a", m="b")).exhaustive, (
        "inference does not know it: the replay judges"
    )


def test_what_must_not_be_known_is_not_known_at_the_end_either(lamps):
    """It is not known before one looks at the other lamp, and no later action mentions it: still it counts."""
    problem = lamps("not K(on(a)) or K(on(b))", "add(Kx, on(a), on(b))")
    tree = look("look", "on(b)", {"true": GOAL, "false": GOAL}, l="b")
    assert "the goal does not hold" in str(verify_plan(problem, plan_of(problem, tree)))
    free = lamps("not K(on(a)) or K(on(b))")
    report = verify_plan(free, plan_of(free, tree))
    assert report.ok and report.judge == "worlds"


def run_plan(problem, plan, **options):
    return validate_worlds(problem, plan, **options)


def test_the_report_of_verification_tells_of_worlds(lamps):
    problem = lamps("K(on(a))")
    report = verify_plan(problem, plan_of(problem, pressed()), knowledge_only=True)
    assert "judged by worlds: 2 worlds, all of them: every one reaches the goal in 1 to 2 actions" in str(report)
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
def test_all_worlds_are_those_that_brute_force_finds(lamps):
    initial = (
        "add(Kx, on(a), on(b), colour(a) = red)",
        "add(Kor, not on(b), colour(b) = green)",
        "add(Kf, colour(b) != red)",
    )
    problem = lamps("true", *initial)
    start = start_of(problem)
    symbols = [("on", ("a",)), ("on", ("b",)), ("colour", ("a",)), ("colour", ("b",))]
    worlds = list(every(start.unknowns, start.world, frozenset(symbols)))
    found = [tuple(world.known[symbol] for symbol in symbols) for world in worlds]
    values = (False, True)
    colours = ("red", "green", "blue")
    expected = {
        (a, b, first, second)
        for a, b, first, second in product(values, values, colours, colours[1:])
        if [a, b, first == "red"].count(True) == 1 and (not b or second == "green")
    }
    assert set(found) == expected
    assert len(found) == len(expected), "none stands there twice"
    assert start.unknowns.count == len(expected)
    assert sum(world.share for world in worlds) == pytest.approx(1.0)


def test_what_is_so_in_every_choice_is_known_at_once(lamps):
    start = start_of(lamps("true", "add(Kx, on(a), on(b))", "add(Kor, on(a), broken(a))", "add(Kf, not on(a))"))
    assert start.world.known["on", ("b",)] is True and start.world.known["broken", ("a",)] is True
    assert not start.unknowns.groups


def test_initial_knowledge_that_contradicts_itself_has_no_world(lamps):
    """Each pair of three is exclusive and exhaustive: inference alone does not see that this cannot be."""
    pairs = ("on(a), on(b)", "on(b), broken(a)", "broken(a), on(a)")
    problem = lamps("true", *(f"add(Kx, {pair})" for pair in pairs))
    report = verify_plan(problem, plan_of(problem, GOAL))
    assert "no world agrees with all of it" in str(report)
