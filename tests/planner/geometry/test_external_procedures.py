"""External procedures end to end: asked where they are met, once, in order; as tests, as values, in effects and goals."""

from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import kabo

DOMAIN = """
domain: couriers
types: [place, parcel]
predicates:
  cheap: [parcel]
functions:
  where: {value: place}
  fuel: {value: number}
  colour: {arguments: [parcel], value: [red, blue]}
PROCEDURES
actions:
  drive:
    parameters: {to: place}
    preconditions:
      - K(to != where)
      - K(fuel >= distance(where, to))
      - safe(where, to)
    effects:
      - add(Kf, fuel = fuel - distance(where, to)), add(Kf, where = to)
  look:
    parameters: {p: parcel}
    effects:
      - K(paint(p) = red) => add(Kf, cheap(p))
      - add(Kf, colour(p) = paint(p))
"""
PROCEDURES = """
procedures:
  distance: {arguments: [place, place], value: number}
  paint: {arguments: [parcel], value: [red, blue]}
  safe: {arguments: [place, place]}
"""
PROBLEM = """
problem: p
objects:
  place: [a, b, c]
  parcel: [x, y]
initial:
  - add(Kf, where = a)
  - add(Kf, fuel = 10)
goal:
  - K(where = c)
  - K(cheap(x))
  - K(colour(y) = paint(y))
"""
SEARCHES = ["best", "greedy", "astar", "breadth-first", "depth-first", "iterative-deepening"]


def load(folder: Path, domain: str = DOMAIN, problem: str = PROBLEM, procedures: str = PROCEDURES) -> kabo.Problem:
    (folder / "domain.yaml").write_text(domain.replace("PROCEDURES", procedures.strip()))
    (folder / "problem.yaml").write_text(problem)
    return kabo.load_problem(folder / "problem.yaml")


def roads(**lengths: float):
    """A symmetric table of distances by `ab`, far away where nothing is said."""
    return lambda one, other: lengths.get(one + other, lengths.get(other + one, 100))


def functions(**more):
    red = {"x": "red", "y": "blue"}
    return {
        "distance": roads(ab=3, bc=3, ac=20),
        "paint": lambda parcel: red[parcel],
        "safe": lambda one, other: True,
        **more,
    }


def actions(plan: kabo.Plan) -> list[str]:
    return [
        f"{node.action} {' '.join(map(str, node.arguments.values()))}"
        for node in plan.nodes.values()
        if node.action
    ]


@pytest.mark.parametrize("search", SEARCHES)
def test_values_and_tests_decide_what_a_plan_may_do(tmp_path, search):
    problem = load(tmp_path)
    result = kabo.solve(problem, procedures=functions(), search=search)
    assert [action for action in actions(result.plan) if action.startswith("drive")][-2:] == ["drive b", "drive c"]
    assert kabo.verify(problem, result.plan, procedures=functions()).findings == ()


def test_a_plan_is_judged_by_what_its_procedures_answer(tmp_path):
    problem = load(tmp_path)
    plan = kabo.solve(problem, procedures=functions()).plan
    unsafe = kabo.verify(problem, plan, procedures=functions(safe=lambda one, other: one != "b"))
    assert any("precondition 3" in finding.message for finding in unsafe.findings)
    repainted = kabo.verify(problem, plan, procedures=functions(paint=lambda parcel: "blue"))
    assert any("the goal" in finding.message for finding in repainted.findings)
    assert kabo.verify(problem, plan).findings  # nobody answers


def test_equal_calls_are_asked_once_and_only_behind_what_stands_before_them(tmp_path):
    calls = Counter()

    def safe(one, other):
        calls[one, other] += 1
        return True

    kabo.solve(load(tmp_path), procedures=functions(safe=safe), search="breadth-first")
    assert set(calls.values()) == {1}
    assert ("a", "c") not in calls  # not enough fuel for it: nobody asks whether it is safe
    assert all(one != other for one, other in calls)


def test_no_plan_says_what_was_refused(tmp_path):
    result = kabo.solve(load(tmp_path), procedures=functions(safe=lambda one, other: other != "c"))
    assert result.status == "no_plan"
    assert "refused: safe(b, c)" in result.reason.details


def test_a_procedure_that_takes_a_seed_is_asked_again_until_it_has_a_value(tmp_path):
    seeds = []

    def paint(parcel, seed):
        seeds.append((parcel, seed))
        return None if seed < 42 else "red"

    problem = load(tmp_path)
    result = kabo.solve(problem, procedures=functions(paint=paint), seed=40)
    assert result.status == "solved"
    assert [seed for parcel, seed in seeds if parcel == "x"] == [40, 41, 42]
    assert result.statistics["procedures"]["paint"] == {"calls": 6, "failures": {"refused": 4}}
    assert kabo.verify(problem, result.plan, procedures=functions(paint=paint)).findings == ()


def test_without_a_value_nothing_is_known_and_what_is_assigned_is_forgotten(tmp_path):
    nothing = functions(paint=lambda parcel: None)
    start = PROBLEM.replace("goal:", "  - add(Kf, colour(y) = blue)\ngoal:")
    forgotten = start.split("goal:")[0] + "goal:\n  - not K(colour(y) = blue)\n"
    assert kabo.solve(load(tmp_path, problem=start), procedures=nothing).status == "no_plan"
    problem = load(tmp_path, problem=forgotten)
    result = kabo.solve(problem, procedures=nothing)
    assert actions(result.plan) == ["look y"]
    assert kabo.verify(problem, result.plan, procedures=nothing).findings == ()


@pytest.mark.parametrize(("name", "answer"), [("paint", "green"), ("distance", "far"), ("distance", float("nan"))])
def test_an_answer_that_the_declaration_does_not_allow_is_an_error_with_its_place(tmp_path, name, answer):
    wrong = functions(**{name: lambda *arguments: answer})
    with pytest.raises(kabo.InputError, match=f"{name}.* answered .*, which is not") as caught:
        kabo.solve(load(tmp_path), procedures=wrong)
    assert caught.value.diagnostics[0].line > 10


def test_a_value_that_nobody_answers_for_is_refused_by_name(tmp_path):
    with pytest.raises(kabo.InputError) as caught:
        kabo.solve(load(tmp_path), procedures={"paint": lambda parcel: "red"})
    assert ['"distance"' in finding.message for finding in caught.value.diagnostics] == [True]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("  - when K", ""),
        ("      - when colour(p) = paint(p) then cheap(p)", "inside `when`"),
        ("      - add(Kx, colour(p) = paint(p), cheap(p))", "in a fact of Kx"),
        ("      - add(Kf, colour(p) != paint(p))", '"!=" between two terms'),
    ],
)
def test_places_that_no_procedure_can_have_are_refused_by_name(tmp_path, text, said):
    if not said:
        domain = DOMAIN.replace(
            "actions:", "update_rules:\n  - forall(parcel p) (K(paint(p) = red) => add(Kf, cheap(p)))\nactions:"
        )
        said = "in an update rule"
    else:
        domain = DOMAIN + text + "\n"
    with pytest.raises(kabo.InputError, match=said):
        kabo.solve(load(tmp_path, domain), procedures=functions())


def test_a_declared_test_may_stand_for_an_action_s_procedure(tmp_path):
    fly = "  fly:\n    parameters: {to: place}\n    geometry: safe(to, to)\n    effects:\n      - add(Kf, where = to)\n"
    domain = DOMAIN.replace("      - safe(where, to)\n", "") + fly
    problem = load(tmp_path, domain)
    far = functions(distance=roads())
    result = kabo.solve(problem, procedures=far)
    assert "fly c" in actions(result.plan)
    refused = functions(distance=roads(), safe=lambda one, other: False)
    assert kabo.solve(problem, procedures=refused).status == "no_plan"
    assert any(
        "fails here" in finding.message
        for finding in kabo.verify(problem, result.plan, procedures=refused).findings
    )


def test_explanations_ask_procedures_too(tmp_path):
    explained = kabo.explain(load(tmp_path), procedures=functions(safe=lambda one, other: False))
    assert explained.verdict == "proved"
    assert kabo.explain(load(tmp_path), procedures=functions()).verdict == "solvable"


lengths = st.integers(1, 12)


@given(
    st.fixed_dictionaries({"ab": lengths, "bc": lengths, "ac": lengths}),
    st.sets(st.sampled_from(["ab", "bc", "ac", "ba", "cb", "ca"])),
    st.sampled_from(SEARCHES),
)
def test_a_procedure_means_the_same_as_facts_that_never_change(tmp_path_factory, table, dangerous, search):
    """The law: a table asked by a procedure and the same table in the problem file give plans for the same problems."""
    folder = tmp_path_factory.mktemp("law")
    answers = functions(distance=roads(**table), safe=lambda one, other: one + other not in dangerous)
    problem = load(folder)
    asked = kabo.solve(problem, procedures=answers, search=search)
    pairs = [(one, other) for one in "abc" for other in "abc" if one != other]
    facts = [f"  - add(Kf, distance({o}, {t}) = {answers['distance'](o, t)})" for o, t in pairs]
    facts += [f"  - add(Kf, safe({o}, {t}))" for o, t in pairs if o + t not in dangerous]
    facts += ["  - add(Kf, paint(x) = red)", "  - add(Kf, paint(y) = blue)"]
    domain = DOMAIN.replace("      - safe(where, to)", "      - K(safe(where, to))")
    declared = "  distance: {arguments: [place, place], value: number}\n  paint: {arguments: [parcel], value: [red, blue]}"
    domain = domain.replace("PROCEDURES", declared).replace("predicates:", "predicates:\n  safe: [place, place]")
    known = kabo.solve(load(folder, domain, PROBLEM.replace("goal:", "\n".join(facts) + "\ngoal:")), search=search)
    assert asked.status == known.status
    if asked.plan is not None:
        assert kabo.verify(problem, asked.plan, procedures=answers).findings == ()
