"""What actions, effects and sensing mean, on plans written by hand."""

from dataclasses import replace

import pytest

from kabo.language import formulas, load_problem
from kabo.plan import Node, Plan, PlanBuilder, ValueOf
from kabo.verify import verify_plan
from kabo.verify.knowledge.replay import run
from tests.verify.hand_made import problem_of

DOMAIN = """domain: post
types:
  place:
  thing: [parcel, letter]
constants:
  place: [store, dock]
predicates:
  held: [thing]
  at: [thing, place]
  damp: [thing]
  marked: [thing]
functions:
  destination: {arguments: [thing], value: [oslo, rome, york]}
  load: {arguments: [], value: number}
  code: {arguments: [place], value: place}
actions:
  take:
    parameters: {t: thing}
    preconditions:
      - K(not held(t))
    effects:
      - add(Kf, held(t), load = load + 1)
      - forall(place p) (K(at(t, p)) => del(Kf, at(t, p)))
  leave:
    parameters: {t: thing, p: place}
    preconditions:
      - K(held(t))
    effects:
      - add(Kf, not held(t), at(t, p))
      - del(Kf, held(t))
  read:
    parameters: {t: thing}
    sense: destination(t)
  look_up:
    parameters: {p: place}
    sense: code(p)
  look_whether_damp:
    parameters: {t: thing}
    effects:
      - add(Kw, damp(t))
  rule_out:
    parameters: {t: thing}
    effects:
      - add(Kf, destination(t) != oslo, destination(t) != rome)
  send:
    parameters: {t: thing, p: {value_of: code(store)}}
    preconditions:
      - K(code(store) = p)
    effects:
      - add(Kf, marked(t))
  soak:
    parameters: {t: thing}
    effects:
      - when held(t) then damp(t)
  swap_marks:
    parameters: {t: thing, u: thing}
    effects:
      - K(marked(t)) => add(Kf, marked(u)), del(Kf, marked(t))
      - K(marked(u)) => add(Kf, marked(t)), del(Kf, marked(u))
"""

PROBLEM = """problem: one
objects:
  parcel: [box]
  letter: [card]
initial:
  - forall(thing t) add(Kf, not held(t))
  - add(Kf, at(box, store), load = 0)
goal: {goal}
"""


@pytest.fixture
def post(tmp_path):
    def make(goal: str, rules: str = ""):
        (tmp_path / "domain.yaml").write_text(DOMAIN.replace("actions:\n", rules + "actions:\n", 1))
        (tmp_path / "one.yaml").write_text(PROBLEM.format(goal=goal))
        return load_problem(tmp_path / "one.yaml")

    return make


def plan_of(problem, root) -> Plan:
    """A plan of nested (action, arguments, what follows); branches are (…, on, {outcome: what follows})."""
    builder = PlanBuilder()

    def add(tree) -> str:
        if tree is None:
            return builder.goal()
        action, arguments, *rest = tree
        if len(rest) == 2:
            on, outcomes = rest
            handles = {outcome: add(inner) for outcome, inner in outcomes.items()}
            kind = "branch" if action is None else "sense"
            return builder.add(Node(kind, action, arguments, on=on, branches=handles))
        delivers = {"look_up": ("code(store)",), "read": ("destination(box)",)}.get(action, ())
        return builder.add(
            Node("sense" if delivers else "action", action, arguments, next=add(rest[0]), delivers=delivers)
        )

    options = {"search": "by hand", "seed": 0, "epsilon": None, "geometry": "none"}
    return builder.build(add(root), problem=problem.name, files=problem.files, options=options)


def said(problem, tree) -> str:
    return str(verify_plan(problem, plan_of(problem, tree)))


BOX, CARD = {"t": "box"}, {"t": "card"}


def test_conditions_are_read_in_the_state_before_and_addition_wins_over_deletion(post):
    problem = post("K(at(box, store)) and K(not held(box)) and K(load = 1)")
    tree = ("take", BOX, ("leave", {**BOX, "p": "store"}, None))
    assert "verified\n" in said(problem, tree) and "NOT" not in said(problem, tree)
    assert "the goal does not hold" in said(problem, ("take", BOX, None))
    exchanged = post("K(load = 0) and not K(marked(box)) and not K(marked(card))")
    assert "NOT" not in said(exchanged, ("swap_marks", {"t": "box", "u": "card"}, None))


def test_a_deleted_fact_is_not_known_and_not_known_to_be_false(post):
    problem = post("not K(at(box, store)) and not K(not at(box, store)) and not Kw(at(box, store))")
    assert "NOT" not in said(problem, ("take", BOX, None))


def test_plans_branch_on_every_value_that_a_term_can_have(post):
    problem = post(
        "exists(thing t) (K(destination(t) = oslo) or K(destination(t) = rome) or K(destination(t) = york))"
    )
    branches = {"oslo": None, "rome": None, "york": None}
    assert "NOT" not in said(problem, ("read", BOX, "destination(box)", branches))
    del branches["rome"]
    assert "no branch for destination(box) = rome" in said(problem, ("read", BOX, "destination(box)", branches))
    strange = {**branches, "rome": None, "paris": None}
    assert '"paris" is no value of destination(box)' in said(problem, ("read", BOX, "destination(box)", strange))


def test_values_that_are_ruled_out_need_no_branch_and_the_last_one_left_is_known(post):
    problem = post("K(destination(box) = york) and K(destination(box) != oslo)")
    assert "NOT" not in said(problem, ("rule_out", BOX, None))
    assert "NOT" not in said(problem, ("rule_out", BOX, ("read", BOX, "destination(box)", {"york": None})))


def test_a_branch_node_decides_on_what_was_sensed_before(post):
    problem = post("Kw(damp(box))")
    decide = (None, {}, "damp(box)", {"false": None, "true": None})
    assert "NOT" not in said(problem, ("look_whether_damp", BOX, decide))
    assert "branches on damp(box), which is not known" in said(problem, ("take", BOX, decide))


def test_inside_a_branch_the_sensed_fact_is_known(post):
    problem = post("K(damp(box)) or K(not damp(box))")
    assert "NOT" not in said(problem, ("look_whether_damp", BOX, "damp(box)", {"false": None, "true": None}))
    assert "the goal does not hold" in said(problem, ("look_whether_damp", BOX, None))


def test_a_run_time_variable_needs_its_value_to_be_known_at_run_time(post):
    problem = post("K(marked(box))")
    send = ("send", {**BOX, "p": ValueOf("code(store)")}, None)
    assert "NOT" not in said(problem, ("look_up", {"p": "store"}, send))
    assert "the value of code(store) is not known at run time here" in said(problem, send)
    wrong = ("send", {**BOX, "p": "store"}, None)
    assert "must be the value of code(store) at run time" in said(problem, ("look_up", {"p": "store"}, wrong))


def test_update_rules_fire_until_nothing_changes(post):
    rules = "update_rules:\n  - forall(thing t) (K(held(t)) => add(Kf, damp(t)))\n"
    rules += "  - forall(thing t) (K(damp(t)) => add(Kf, marked(t)))\n"
    assert "NOT" not in said(post("K(marked(box))", rules), ("take", BOX, None))
    endless = "update_rules:\n  - forall(thing t) (K(damp(t)) => del(Kf, damp(t)))\n"
    endless += "  - forall(thing t) (not K(damp(t)) => add(Kf, damp(t)))\n"
    assert "still change something after" in said(post("K(held(box))", endless), ("take", BOX, None))
    growing = "update_rules:\n  - add(Kf, load = load + 1)\n"
    assert "load = 1, which is known not to hold" in said(post("K(held(box))", growing), ("take", BOX, None))


def test_a_diamond_of_many_levels_is_replayed_in_as_many_steps_as_it_has_nodes(post):
    problem = post("K(held(box))")
    builder = PlanBuilder()
    last = builder.add(Node("action", "take", BOX, next=builder.goal()))
    for _ in range(40):
        for thing in ("box", "card"):
            sides = dict.fromkeys(("false", "true"), last)
            last = builder.add(
                Node("sense", "look_whether_damp", {"t": thing}, on=f"damp({thing})", branches=sides)
            )
    options = {"search": "by hand", "seed": 0, "epsilon": None, "geometry": "none"}
    plan = builder.build(last, problem="one", files=problem.files, options=options)
    report = verify_plan(problem, plan)
    assert report.ok and report.leaves == 2**80 and report.states < 400


def test_a_geometric_test_is_not_judged_where_there_is_geometry_and_succeeds_where_there_is_none(counter, post):
    asked = formulas.Test(formulas.ProcedureCall("reachable", ()))
    goal = replace(counter.problem, goal=(*counter.problem.goal, asked))
    assert "a geometric test inside a formula is not judged" in str(
        verify_plan(goal, counter.plan, knowledge_only=True)
    )
    name = next(node.action for node in counter.plan.nodes.values() if node.action is not None)
    action = counter.problem.domain.actions[name]
    action = replace(action, preconditions=(*action.preconditions, asked))
    domain = replace(counter.problem.domain, actions={**counter.problem.domain.actions, name: action})
    text = str(verify_plan(replace(counter.problem, domain=domain), counter.plan, knowledge_only=True))
    assert "a geometric test inside a formula is not judged" in text
    symbolic = post("true")
    assert verify_plan(replace(symbolic, goal=(asked,)), plan_of(symbolic, ("take", BOX, None))).ok


def test_too_many_different_states_are_not_judged_and_that_is_said(post, monkeypatch):
    monkeypatch.setattr(run, "MAX_STATES", 1)
    rules = "update_rules:\n  - forall(thing t) (K(held(t)) => add(Kf, damp(t)))\n"  # worlds do not judge these
    text = said(post("K(held(box))", rules), ("take", BOX, ("take", CARD, ("read", BOX, None))))
    assert "the rest was not judged" in text and "NOT verified" in text


def test_a_motion_that_begins_early_counts_on_no_effect_of_the_one_before(tmp_path):
    """Going through the door needs it open; ringing does not."""
    domain = """types: [door]
predicates: {open: [door], through: [], rung: []}
actions:
  push:
    parameters: {d: door}
    effects: ['add(Kf, open(d))']
  pass:
    parameters: {d: door}
    preconditions: ['K(open(d))']
    effects: ['add(Kf, through)']
  ring:
    effects: ['add(Kf, rung)']
"""
    problem = problem_of(
        tmp_path,
        domain,
        """domain: domain.yaml
objects: {door: [d]}
initial: ['add(Kf, not open(d), not through, not rung)']
goal: ['K(through)', 'K(rung)']
""",
    )
    plan = plan_of(problem, ("push", {"d": "d"}, ("ring", {}, ("pass", {"d": "d"}, None))))
    for name, early in (("n1", True), ("n2", True)):
        nodes = {**plan.nodes, name: replace(plan.nodes[name], overlap=0.5)}
        report = verify_plan(problem, replace(plan, nodes=nodes))
        assert report.ok is early, str(report)
    nodes = {**plan.nodes, "n1": replace(plan.nodes["n2"], next="n2", overlap=0.5), "n2": plan.nodes["n1"]}
    nodes["n2"] = replace(nodes["n2"], next="n3")
    report = verify_plan(problem, replace(plan, nodes=nodes))
    assert [f.node for f in report.findings] == ["n1"], str(report)
    assert "begins early, but then precondition 1" in report.findings[0].message
