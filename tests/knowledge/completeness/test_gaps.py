"""Where knowledge is complete, and what makes it incomplete, with its place."""

from pathlib import Path

import pytest

from kabo.knowledge import verdict_of
from kabo.knowledge.completeness.gaps import Gap
from kabo.language import load_problem

ROOT = Path(__file__).parents[3]

HEAD = "(define (domain c) (:predicates (p) (q) (r) (g))"
PROBLEM = "(define (problem c1) (:domain c)"


def judged(folder: Path, actions: str, start: str, goal: str):
    """The verdict on a PDDL problem; its actions begin in line 2, its initial state in the line after them."""
    (folder / "p.pddl").write_text(f"{HEAD}\n{actions})\n{PROBLEM} (:init {start})\n (:goal {goal}))\n")
    return verdict_of(load_problem(folder / "p.pddl"))


def own(folder: Path, actions: str, start: str, goal: str, functions: str = ""):
    """The verdict on a problem in kabo's own language."""
    (folder / "domain.yaml").write_text(
        "domain: d\ntypes: [thing]\nconstants:\n  thing: [x, y]\npredicates:\n  p: []\n  q: []\n  r: []\n  at: [thing]\n"
        f"functions:\n  f: {{arguments: [], value: [u, v, w]}}\n  g: {{arguments: [], value: [u, v, w]}}\n"
        f"  n: {{arguments: [], value: number}}\n  spot: {{arguments: [], value: thing}}\n{functions}actions:\n{actions}"
    )
    lines = "".join(f"  - {each}\n" for each in start.split("|") if each)
    wanted = "".join(f"  - {each}\n" for each in goal.split("|"))
    (folder / "p.yaml").write_text(
        f"problem: p\ndomain: domain.yaml\n{'initial:' if lines else ''}\n{lines}goal:\n{wanted}"
    )
    return verdict_of(load_problem(folder / "p.yaml"))


def told(verdict) -> list[str]:
    """The gaps with line and column."""
    assert all(isinstance(gap, Gap) and gap.place is not None for gap in verdict.gaps)
    return [f"{gap.place.line}:{gap.place.column}: {gap.text}" for gap in verdict.gaps]


# ------------------------------------------------------------------------------------------------------ constructs
CASES = [
    (
        "(:action a :parameters () :effect (when (p) (q))) (:action b :parameters () :effect (when (not (p)) (q)))",
        "(unknown (p))",
        "(q)",
        ["`when`", "`when`"],
    ),
    (
        "(:action a :parameters () :precondition (or (p) (q)) :effect (g))",
        "(oneof (p) (q))",
        "(g)",
        ["one of several"],
    ),
    (
        "(:action a :parameters () :precondition (p) :effect (g))",
        "(or (p) (q)) (or (p) (not (q)))",
        "(g)",
        ["overlaps"],
    ),
    (
        "(:action a :parameters () :effect (p)) (:action s :parameters () :observe (q))"
        "(:action b :parameters () :precondition (r) :effect (g))",
        "(oneof (p) (q) (r))",
        "(g)",
        ["may change p while it is unknown"],
    ),
]


@pytest.mark.parametrize(("actions", "start", "goal", "wanted"), CASES)
def test_what_knowledge_does_not_follow_is_told(tmp_path, actions, start, goal, wanted):
    verdict = judged(tmp_path, actions, start, goal)
    assert not verdict.is_proof
    assert len(verdict.gaps) == len(wanted)
    for text, part in zip(told(verdict), wanted, strict=True):
        assert part in text


def test_the_place_is_that_of_the_construct(tmp_path):
    verdict = judged(tmp_path, "(:action a :parameters () :effect (when (p) (q)))", "(unknown (p))", "(q)")
    assert told(verdict) == ['2:45: what `when` does in action "a" depends on what may be unknown: p']
    assert str(verdict.gaps[0]).startswith(f"{tmp_path}/p.pddl:2:45: ")


SENSE = "  weigh:\n    sense: n\n"
LIFT = "  lift:\n    preconditions:\n      - K(n <= 2)\n    effects:\n      - add(Kf, p)\n"
OWN = [
    (SENSE + LIFT, "", "K(p)", "senses a number"),
    (
        "  a:\n    sense: f\n  b:\n    effects:\n      - add(Kf, g = f)\n",
        "add(Kf, g = u)",
        "K(g = v)",
        "copies a value",
    ),
    ("  a:\n    sense: f\n  b:\n    sense: g\n", "", "K(f = g)", "compares two values"),
    ("  a:\n    sense: spot\n", "add(Kf, at(x), at(y))", "K(at(spot))", "names something by a value"),
    ("  a:\n    effects:\n      - add(Kf, n = n * n)\n", "", "K(n >= 0)", "computes with a number"),
]


@pytest.mark.parametrize(("actions", "start", "goal", "wanted"), OWN)
def test_constructs_of_kabo_s_own_language_are_told(tmp_path, actions, start, goal, wanted):
    verdict = own(tmp_path, actions, start, goal)
    assert [wanted in text for text in told(verdict)] == [True], told(verdict)


def test_rules_about_what_is_unknown_are_told(tmp_path):
    rules = "update_rules:\n  - K(q) => add(Kf, p)\n"
    verdict = own(tmp_path, "  a:\n    sense: q\n", "", "K(p)", rules)
    assert ["update rule" in text for text in told(verdict)] == [True]


# -------------------------------------------------------------------------------------------------------- complete
def test_disjunctions_of_what_is_independent_are_complete(tmp_path):
    action = "(:action a :parameters () :precondition (or (p) (q)) :effect (g))"
    assert judged(
        tmp_path, action + "(:action s :parameters () :observe (p))", "(unknown (p) (q))", "(g)"
    ).is_proof


def test_in_kabo_s_own_language_a_disjunction_is_one_of_knowledge(tmp_path):
    assert own(tmp_path, "  a:\n    sense: p\n", "add(Kx, p, q)", "K(p) or K(not p)|K(r)").is_proof
    verdict = own(tmp_path, "  a:\n    sense: r\n", "add(Kx, p, q)", "K(p) or K(q)|K(r)")
    assert verdict.is_proof and not verdict.gaps


def test_when_is_complete_where_its_condition_is_known(tmp_path):
    known = "  a:\n    preconditions:\n      - Kw(p)\n    effects:\n      - when p then q\n  b:\n    sense: p\n"
    assert own(tmp_path, known, "add(Kf, not q)", "K(q)").is_proof
    assert not own(tmp_path, known.replace("Kw(p)", "K(r)"), "add(Kf, not q)|add(Kf, r)", "K(q)").is_proof


def test_what_does_not_matter_for_the_goal_is_no_gap(tmp_path):
    verdict = judged(
        tmp_path,
        "(:action a :parameters () :effect (when (p) (q))) (:action b :parameters () :precondition (r) :effect (g))"
        "(:action s :parameters () :observe (r))",
        "(unknown (p) (r))",
        "(g)",
    )
    assert verdict.is_proof and not verdict.impossible and not verdict.gaps


def test_what_nothing_brings_about_is_impossible_whatever_knowledge_follows(tmp_path):
    verdict = judged(
        tmp_path, "(:action a :parameters () :effect (when (p) (not (q))))", "(unknown (p))", "(and (q) (g))"
    )
    assert verdict.impossible and verdict.is_proof


def test_changing_one_of_several_loses_nothing_where_it_is_known(tmp_path):
    heal = "(:action a :parameters () :precondition (p) :effect (and (not (p)) (g)))"
    look = "(:action s :parameters () :observe (p))"
    assert judged(tmp_path, heal + look, "(oneof (p) (q) (r))", "(and (g) (r))").is_proof


@pytest.mark.parametrize(
    "name",
    ["asking_bartender/n3", "bartender/four_bottles", "bomb_in_the_toilet/n3", "btcs/n4", "canadian_traveller/n3"]
    + ["coloured_balls/n4_2", "doors/n3", "elogistics/n3", "force_sensing/n3", "grid/n3", "logistics/n3"]
    + ["rovers/n4", "stacked/n4", "unix/n2", "circular_rearrange/n3"],
)
def test_knowledge_is_complete_for_the_shipped_problem(name):
    assert verdict_of(load_problem(ROOT / "domains" / f"{name}.yaml")).gaps == ()
