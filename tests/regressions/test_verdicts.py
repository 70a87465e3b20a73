"""Problems that were "proved" to have no plan although they have one, and one in which no search ended."""

import json
from pathlib import Path

import jsonschema
import pytest

import kabo
from kabo.cli import main
from kabo.planner.search.algorithms import ALGORITHMS
from kabo.planner.solve import solve

SCHEMAS = Path(kabo.__file__).parent / "plan" / "schemas"

CONF = """(define (domain c) (:predicates (p) (q))
 (:action a :parameters () :effect (when (p) (q)))
 (:action b :parameters () :effect (when (not (p)) (q))))
(define (problem c1) (:domain c) (:init (unknown (p))) (:goal (q)))
"""
PUSH = """(define (domain c) (:predicates (at ?x) (d ?x)) (:constants l r)
 (:action push :parameters () :effect (and (when (at l) (and (at r) (not (at l)))))))
(define (problem c1) (:domain c) (:init (oneof (at l) (at r))) (:goal (at r)))
"""
EITHER = """(define (domain c) (:predicates (p) (q) (g))
 (:action a :parameters () :precondition (or (p) (q)) :effect (g)))
(define (problem c1) (:domain c) (:init (oneof (p) (q))) (:goal (g)))
"""
CLAUSE = """(define (domain c) (:predicates (p) (q) (g))
 (:action a :parameters () :precondition (p) :effect (g)))
(define (problem c1) (:domain c) (:init (or (p) (q)) (or (p) (not (q)))) (:goal (g)))
"""
CASES = {"conf": (CONF, "2:44"), "push": (PUSH, "2:55"), "either": (EITHER, "2:42"), "clause": (CLAUSE, "3:41")}

WEIGH = """domain: lifting
types: [obj]
predicates:
  done: [obj]
functions:
  weight: {arguments: [obj], value: number}
actions:
  weigh:
    parameters: {o: obj}
    sense: weight(o)
  lift_one_hand:
    parameters: {o: obj}
    preconditions:
      - K(weight(o) <= 2)
    effects:
      - add(Kf, done(o))
  lift_two_hands:
    parameters: {o: obj}
    preconditions:
      - K(weight(o) > 2)
    effects:
      - add(Kf, done(o))
"""

ENDLESS = """(define (domain r)
 (:predicates (p0) (p1) (p2) (p3) (p4) (p5))
 (:action a0 :parameters () :effect (when (and (not (p5)) (not (p3))) (p3)))
 (:action a1 :parameters () :effect (and (when (not (p4)) (p2)) (when (p0) (p3))))
 (:action a2 :parameters () :effect (and (when (and (not (p0)) (p3)) (p1)) (when (and (not (p4)) (p2)) (not (p4)))))
 (:action a3 :parameters () :precondition (not (p4)) :effect (and (not (p2)) (when (and (p3) (not (p2))) (p3))))
 (:action a4 :parameters () :effect (and (p2) (when (p1) (p0))))
 (:action s0 :parameters () :observe (p1))
 (:action s1 :parameters () :observe (p0))
 (:action s2 :parameters () :precondition (p2) :observe (p5)))
(define (problem r1) (:domain r)
 (:init (p2) (unknown (p0)) (unknown (p5)) (unknown (p3)) (unknown (p1)) (or (p5) (p0)) (or (p5) (not (p1)))
  (oneof (p1) (p0) (p3) (p5)))
 (:goal (and (p1) (not (p5)))))
"""


@pytest.fixture
def said(tmp_path, capsys, monkeypatch):
    """Runs a command on a file with this text; its exit code and the object that it prints."""
    monkeypatch.chdir(tmp_path)

    def run(command: str, text: str, *options: str):
        Path("p.pddl").write_text(text)
        code = main([command, "p.pddl", "--json", *options])
        body = json.loads(capsys.readouterr().out)
        kind = "result" if command == "solve" else command
        jsonschema.validate(body, json.loads((SCHEMAS / f"kabo-{kind}-1.schema.json").read_text()))
        return code, body

    return run


@pytest.mark.parametrize("search", sorted(ALGORITHMS))
@pytest.mark.parametrize("name", CASES)
def test_what_takes_reasoning_by_cases_is_not_proved_to_have_no_plan(said, name, search):
    text, place = CASES[name]
    code, body = said("solve", text, "--search", search, "-o", "plan.json")
    assert (code, body["status"]) == (4, "exhausted")
    reason = body["reason"]
    assert (reason["proved"], reason["budget"]) == (None, "reasoning")
    assert reason["message"].startswith("not on the knowledge level")
    assert any(detail.startswith(f"p.pddl:{place.partition(':')[0]}:") for detail in reason["details"]), reason


@pytest.mark.parametrize("name", CASES)
def test_explain_claims_no_proof_either(said, name):
    code, body = said("explain", CASES[name][0])
    assert (code, body["verdict"]) == (4, "exhausted")
    assert "not on the knowledge level" in body["summary"][0] and "p.pddl:" in body["summary"][1]
    text = " ".join(body["summary"])
    assert "all of them have been tried" not in text and "There is no plan" not in text


def test_what_is_of_no_use_is_told_with_the_same_reserve(tmp_path, capsys):
    (tmp_path / "p.pddl").write_text(EITHER)
    assert main(["explain", str(tmp_path / "p.pddl")]) == 4
    assert "Of no use, as far as kabo's knowledge goes:" in capsys.readouterr().out


@pytest.mark.parametrize("search", sorted(ALGORITHMS))
def test_a_number_that_is_sensed_is_beyond_knowledge(tmp_path, search):
    (tmp_path / "domain.yaml").write_text(WEIGH)
    (tmp_path / "p.yaml").write_text(
        "problem: p\ndomain: domain.yaml\nobjects:\n  obj: [a]\n"
        "initial:\n  - add(Kf, not done(a))\ngoal:\n  - K(done(a))\n"
    )
    result = solve(kabo.load_problem(tmp_path / "p.yaml"), search=search)
    assert (result.status, result.reason.budget) == ("exhausted", "reasoning")
    assert "domain.yaml:10:12: " in result.reason.details[0]


@pytest.mark.parametrize("search", sorted(ALGORITHMS))
def test_a_search_on_ten_beliefs_ends(said, search):
    """1,143 states of knowledge for ten beliefs, 1,001 of them different; it took 5,797 expansions at most."""
    code, body = said("solve", ENDLESS, "--search", search, "-o", "plan.json")
    assert (code, body["reason"]["budget"]) == (4, "reasoning")
    assert body["statistics"]["expanded"] < 10_000


COURIER = """domain: courier
types: [parcel, place]
predicates:
  at: [parcel, place]
functions:
  address: {arguments: [parcel], value: place}
actions:
  read:
    parameters: {p: parcel}
    sense: address(p)
  deliver:
    parameters: {p: parcel, l: {value_of: address(p)}}
    effects:
      - EFFECT
"""


def courier(folder: Path, effect: str) -> kabo.Problem:
    (folder / "domain.yaml").write_text(COURIER.replace("EFFECT", effect))
    (folder / "p.yaml").write_text(
        "problem: p\ndomain: domain.yaml\nobjects:\n  parcel: [p1]\n  place: [l1, l2, l3]\n"
        "initial:\n  - forall(parcel p, place l) add(Kf, not at(p, l))\n"
        "goal:\n  - forall(parcel p) K(at(p, address(p)))\n"
    )
    return kabo.load_problem(folder / "p.yaml")


@pytest.mark.parametrize("effect", ["add(Kf, at(p, l))", "when address(p) = l then at(p, l)"])
def test_the_remedy_for_a_run_time_variable_in_an_atom_is_one_that_works(tmp_path, effect):
    with pytest.raises(kabo.InputError) as caught:
        kabo.solve(courier(tmp_path, effect))
    (finding,) = caught.value.diagnostics
    assert "forall(" in finding.hint and " x) when f(…) = x then p(x)" in finding.hint
    problem = courier(tmp_path, "forall(place x) when address(p) = x then at(p, x)")
    result = kabo.solve(problem)
    assert result.status == "solved" and kabo.verify(problem, result.plan).ok
