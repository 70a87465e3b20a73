"""Initial states: what is not mentioned is false; what is unknown, and what is known of it (the CLG dialect)."""

import cProfile
import pstats

import pytest

from kabo import load_problem
from tests.language.samples import CLG
from tests.language.written import effects, initial, preconditions, read, refused, warnings

DOMAIN = """(define (domain d) (:predicates (p ?x) (r) (s)) (:functions (f ?x) - number (g) - object)
    (:action look :parameters (?x) :observe (p ?x)))"""
FALSE = ["forall(object x) add(Kf, not p(x))", "add(Kf, not r)", "add(Kf, not s)"]


def problem(init: str) -> str:
    """A problem with an initial state."""
    return f"(define (problem one) (:domain d) (:objects a b c) (:init {init} (= (g) a)) (:goal (r)))"


def after_falsehoods(found) -> list[str]:
    """The initial updates behind those that say what is false, without the value of (g)."""
    texts = initial(found)
    assert texts[:3] == FALSE
    return [each for each in texts[3:] if each != "add(Kf, g = a)"]


@pytest.mark.parametrize(
    ("init", "expected"),
    [
        ("", []), ("(and)", []), ("(p a) (r)", ["add(Kf, p(a), r)"]), ("(and (p a) (and (r)))", ["add(Kf, p(a), r)"]),
        ("(and (p a)) (r)", ["add(Kf, p(a), r)"]), ("(not (p a)) (p b) (p b)", ["add(Kf, p(b))"]),
        ("(unknown (p a))", ["del(Kf, not p(a))"]), ("(unknown (r) (s))", ["del(Kf, not r, not s)"]),
        ("(oneof (p a) (p b) (r))", ["del(Kf, not p(a), not p(b), not r)", "add(Kx, p(a), p(b), r)"]),
        ("(oneof (p a) (not (r)))", ["del(Kf, not p(a), not r)", "add(Kx, p(a), not r)"]),
        ("(oneof (p a) (p a))", ["add(Kf, p(a))"]), ("(or (p a))", ["add(Kf, p(a))"]),
        ("(or (p a) (not (p b)))", ["del(Kf, not p(a), not p(b))", "add(Kor, p(a), not p(b))"]),
        ("(or (p a) (not (p a)))", []),
        ("(or (and (p a) (p b)) (r))",
         ["del(Kf, not p(a), not r, not p(b))", "add(Kor, p(a), r)", "add(Kor, p(b), r)"]),
        ("(imply (r) (s))", ["del(Kf, not r, not s)", "add(Kor, not r, s)"]),
        ("(not (and (r) (s)))", ["del(Kf, not r, not s)", "add(Kor, not r, not s)"]),
        ("(p a) (oneof (p a) (p b))", ["del(Kf, not p(b))", "add(Kf, p(a))", "add(Kx, p(a), p(b))"]),
        ("(not (p a)) (oneof (p a) (p b) (p c))",
         ["del(Kf, not p(b), not p(c))", "add(Kx, p(a), p(b), p(c))"]),
        ("(oneof (p a) (p b)) (unknown (p a)) (oneof (p b) (r))",
         ["del(Kf, not p(a), not p(b), not r)", "add(Kx, p(a), p(b))", "add(Kx, p(b), r)"]),
        ("(= (f a) -2.5) (= (f b) 1e2)", ["add(Kf, f(a) = -2.5, f(b) = 100, g = a)"]),
    ],
)  # fmt: skip
def test_an_initial_state_becomes_knowledge(tmp_path, init, expected):
    assert after_falsehoods(read(tmp_path, DOMAIN, problem(init))) == expected


def test_a_choice_of_conjunctions_is_one_of_cases(tmp_path):
    """Exactly one of the cases holds, and each holds if and only if its parts do."""
    found = read(tmp_path, DOMAIN, problem("(oneof (and (p a) (not (r))) (p b) (and (p c) (r)))"))
    assert [each for each in initial(found) if "forall" not in each][2:] == [
        "add(Kf, not case_1)", "add(Kf, not case_2)",
        "del(Kf, not case_1, not p(a), not r, not case_2, not p(c), not p(b))",
        "add(Kf, g = a)", "add(Kx, case_1, p(b), case_2)",
        "add(Kor, not case_1, p(a))", "add(Kor, not case_1, not r)", "add(Kor, case_1, not p(a), r)",
        "add(Kor, not case_2, p(c))", "add(Kor, not case_2, r)", "add(Kor, case_2, not p(c), not r)",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("init", "message"),
    [
        ("(p a) (not (p a))", '"(not (p a))" contradicts what stands before'),
        ("(unknown (p a)) (p a)", "this atom is said to be unknown, and to be true"),
        ("(= (f a) 1) (= (f a) 2)", '"(= (f a) 2)" contradicts what stands before'),
        ("(oneof)", "(oneof) has no members in :init"),
        ("(oneof (or (p a) (r)) (s))", '"or" inside of (oneof …) is not supported in :init'),
        ("(unknown)", 'expected "(unknown (p …))"'),
        ("(or (r) (= a b))", "a comparison inside of a disjunction is not supported in :init"),
        ("(or (r) (forall (?x) (p ?x)))", "a quantifier inside of a disjunction is not supported in :init"),
        ("(forall (?x) (p ?x))", '"forall" is not supported in :init'),
        ("(probabilistic 0.5 (r))", '"probabilistic" is not supported in :init'),
        ("(at 5 (r))", "a fact at a later time (at t …) is not supported in :init"),
        ("(= (f a) b)", "a number is compared with an object"),
        ("(= a b)", 'expected "(= (function object …) value)" in :init'),
        ("(= (f a) (f b))", 'expected "(= (function object …) value)" in :init'),
        ("(p ?x)", 'unknown variable "?x" in :init'),
        ("(p (g))", "only objects may be arguments in :init"),
        ("(f a)", '"f" is a function, not a predicate'),
    ],
)  # fmt: skip
def test_what_an_initial_state_cannot_say_is_refused(tmp_path, init, message):
    assert message in [each.message for each in refused(tmp_path, DOMAIN, problem(init))]


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ("(:hidden (r))", "a hidden true state is not supported (:hidden)"),
        ("(:constraints (r))", "constraints on the whole plan are not supported (:constraints)"),
        ("(:goals (r))", 'unknown section ":goals" of a problem'),
        ("(:goal (s))", 'the section ":goal" stands twice in this problem'),
    ],
)
def test_sections_of_other_kinds_are_refused(tmp_path, section, message):
    text = problem("")[:-1] + section + ")"
    assert message in [each.message for each in refused(tmp_path, DOMAIN, text)]


def test_a_problem_without_goal_or_initial_state_is_refused(tmp_path):
    found = refused(tmp_path, DOMAIN, "(define (problem one) (:domain d))")
    assert {each.message for each in found} >= {
        'a problem needs the section ":init"', 'a problem needs the section ":goal"',
    }  # fmt: skip


# ------------------------------------------------------------------------------------------------ what is unknown
def test_a_contingent_problem_senses_and_has_world_effects(tmp_path):
    found = read(tmp_path, CLG)
    assert effects(found, "mix") == [
        "add(Kf, mixed)", "forall(illness i, tint c) when ill(i) and shows(i, c) then stained(c)",
    ]  # fmt: skip
    assert [str(each.predicate) for each in found.domain.actions["look"].sense] == ["stained"]
    assert found.domain.actions["look"].effects == ()
    assert effects(found, "treat") == ["when ill(i) then not ill(i) and cured", "when not ill(i) then not alive"]
    assert preconditions(found, "treat") == []


@pytest.mark.parametrize(
    ("effect", "expected"),
    [
        ("(when (r) (s))", ["when r then s"]), ("(when (k) (s))", ["K(k) => add(Kf, s)"]),
        ("(when (and (k) (r)) (s))", ["when k and r then s"]),
        ("(when (or (r) (k)) (s))", ["when r then s", "K(k) => add(Kf, s)"]),
        ("(when (exists (?z) (p ?z)) (s))", ["forall(object z) when p(z) then s"]),
        ("(when (and (exists (?z) (p ?z)) (exists (?z) (p ?z))) (s))",
         ["forall(object z, object z_2) when p(z) and p(z_2) then s"]),
        ("(when (and (not (= ?x a)) (p ?x)) (s))", ["K(x != a) => when p(x) then s"]),
        ("(when (and (forall (?z) (known ?z)) (p ?x)) (s))",
         ["forall(object z) K(known(z)) => when p(x) then s"]),
        ("(forall (?z) (when (p ?z) (not (p ?z))))", ["forall(object z) when p(z) then not p(z)"]),
        ("(and (s) (when (r) (not (s))))", ["add(Kf, s)"]),
        ("(and (not (s)) (when (r) (s)))", ["when not r then not s", "when r then s"]),
        ("(and (p a) (forall (?z) (when (p ?z) (not (p ?z)))))",
         ["add(Kf, p(a))", "forall(object z) (K(z != a) => when p(z) then not p(z))"]),
        ("(and (when (r) (s)) (when (s) (t)))", ["when r then s", "when s then t"]),
    ],
)  # fmt: skip
def test_effects_of_what_may_be_unknown_are_effects_on_the_world(tmp_path, effect, expected):
    """Unknown are r and p at the start, then s and t because of them."""
    domain = f"""(define (domain d) (:constants a) (:predicates (p ?x) (known ?x) (r) (s) (t) (k))
        (:action act :parameters (?x) :effect {effect}))"""
    text = "(define (problem one) (:domain d) (:objects b) (:init (unknown (r)) (unknown (p a))) (:goal (t)))"
    assert effects(read(tmp_path, domain, text), "act") == expected


@pytest.mark.parametrize(
    ("effect", "message"),
    [
        ("(when (forall (?z) (p ?z)) (r))", "says (forall …) of what may be unknown (p), which is not supported"),
        ("(when (r) (increase (f a) 1))", "depending on what may be unknown is not supported"),
        ("(and (not (s)) (forall (?z) (when (p ?z) (s))))", "nobody knows whether it does: not supported"),
    ],
)
def test_effects_that_cannot_be_said_of_the_unknown_are_refused(tmp_path, effect, message):
    domain = f"""(define (domain d) (:constants a) (:predicates (p ?x) (r) (s)) (:functions (f ?x))
        (:action act :parameters (?x) :effect {effect}))"""
    text = "(define (problem one) (:domain d) (:objects b) (:init (unknown (r)) (unknown (p a))) (:goal (s)))"
    assert any(message in each.message for each in refused(tmp_path, domain, text))


def test_what_kabo_takes_more_strictly_is_warned_of(tmp_path):
    domain = """(define (domain d) (:predicates (p ?x) (r) (s) (k))
        (:action one :precondition (or (r) (s)) :effect (k))
        (:action two :parameters (?x ?y) :effect (and (when (p ?x) (not (p ?x))) (when (p ?y) (p ?x)))))"""
    text = "(define (problem one) (:domain d) (:objects a) (:init (unknown (r)) (unknown (p a))) (:goal (k)))"
    found = warnings(tmp_path, domain, text)
    assert [each.severity for each in found] == ["warning", "warning"]
    assert "one part must be known here" in found[0].message
    assert "both are taken as they stand" in found[1].message


@pytest.mark.parametrize(
    ("observe", "sensed", "message"),
    [
        ("(p ?x)", ["p"], None), ("(not (p ?x))", ["p"], None), ("(and (p ?x) (r))", ["p", "r"], None),
        ("(or (r) (s))", [], '"or" in :observe is not supported in action "look"'),
        ("(q)", [], 'unknown predicate "q" in action "look"'),
        ("(r) :effect (not (r))", [], 'sensing what the same action changes is not supported in action "look"'),
    ],
)  # fmt: skip
def test_observations(tmp_path, observe, sensed, message):
    domain = f"(define (domain d) (:predicates (p ?x) (r) (s)) (:action look :parameters (?x) :observe {observe}))"
    text = "(define (problem one) (:domain d) (:objects a) (:init) (:goal (r)))"
    if message is None:
        found = read(tmp_path, domain, text)
        assert [each.predicate for each in found.domain.actions["look"].sense] == sensed
    else:
        assert message in [each.message for each in refused(tmp_path, domain, text)]


def test_the_work_of_loading_grows_with_the_number_of_atoms_and_not_faster(tmp_path):
    (tmp_path / "domain.pddl").write_text(
        "(define (domain d) (:types t) (:predicates (near ?x ?y - t) (r)) (:action a :effect (r)))"
    )
    calls = {}
    for count in (500, 5000):
        objects = count // 10
        atoms = "\n".join(f"(near o{n % objects} o{(n * 7 + n // objects) % objects})" for n in range(count))
        names = " ".join(f"o{n}" for n in range(objects))
        path = tmp_path / "problem.pddl"
        path.write_text(f"(define (problem one) (:domain d) (:objects {names} - t) (:init {atoms}) (:goal (r)))")
        profile = cProfile.Profile()
        found = profile.runcall(load_problem, path)
        assert sum(len(each.facts) for each in found.initial if hasattr(each, "facts")) == count + 1
        calls[count] = pstats.Stats(profile).total_calls
    assert calls[5000] < 11 * calls[500]
