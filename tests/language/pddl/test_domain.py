"""PDDL domains: declarations, conditions, effects, costs, and what is refused by name."""

import pytest

from kabo.language.spelling import spell
from tests.language.written import effects, initial, preconditions, read, refused, warnings
from tests.support.counted_calls import calls_made

PROBLEM = "(define (problem one) (:domain d) (:objects {objects}) (:init {initial}) (:goal {goal}) {more})"


def domain(action: str = "", *, predicates: str = "(p ?x) (q ?x ?y) (r)", more: str = "") -> str:
    """A domain with one action, given by its parts."""
    act = f"(:action act {action})" if action else ""
    return f"(define (domain d) {more} (:predicates {predicates}) {act})"


def problem(*, objects: str = "a b", initial: str = "(p a)", goal: str = "(r)", more: str = "") -> str:
    """A problem of that domain."""
    return PROBLEM.format(objects=objects, initial=initial, goal=goal, more=more)


TYPES = "(:types van lorry - truck truck boat - vehicle place)"


# ---------------------------------------------------------------------------------------------------- declarations
def test_types_form_a_tree_below_object(tmp_path):
    found = read(tmp_path, domain(more=TYPES), problem())
    assert dict(found.domain.types) == {
        "object": None, "vehicle": "object", "truck": "vehicle", "van": "truck", "lorry": "truck",
        "boat": "vehicle", "place": "object",
    }  # fmt: skip


def test_without_types_there_is_one(tmp_path):
    found = read(tmp_path, domain(), problem())
    assert dict(found.domain.types) == {"object": None}
    assert found.domain.predicates == {"p": ("object",), "q": ("object", "object"), "r": ()}
    assert found.objects == {"a": "object", "b": "object"}


def test_a_predicate_for_several_types_is_declared_with_their_nearest_common_one(tmp_path):
    given = domain(more=TYPES, predicates="(r) (p ?x - (either van lorry)) (s ?x - (either van place))")
    found = read(tmp_path, given, problem(objects="v - van", initial="(p v)"))
    assert found.domain.predicates == {"r": (), "p": ("truck",), "s": ("object",)}


def test_a_parameter_of_several_types_is_one_of_them(tmp_path):
    given = domain(
        ":parameters (?x - (either van boat) ?y - (either van lorry truck)) :effect (r)", more=TYPES,
        predicates="(r)",
    )  # fmt: skip
    found = read(tmp_path, given, problem(objects="", initial=""))
    assert [each.type for each in found.domain.actions["act"].parameters] == ["vehicle", "truck"]
    assert preconditions(found, "act") == [
        "exists(van x_as_van) K(x = x_as_van) or exists(boat x_as_boat) K(x = x_as_boat)"
    ]


def test_a_quantifier_over_several_types_is_one_for_each(tmp_path):
    given = domain(
        """:precondition (and (forall (?x - (either van boat)) (p ?x)) (exists (?x - (either van boat)) (p ?x)))
        :effect (forall (?x - (either van boat)) (not (p ?x)))""",
        more=TYPES, predicates="(r) (p ?x - vehicle)",
    )  # fmt: skip
    found = read(tmp_path, given, problem(objects="", initial=""))
    assert preconditions(found, "act") == [
        "forall(van x) K(p(x))", "forall(boat x) K(p(x))",
        "exists(van x) K(p(x)) or exists(boat x) K(p(x))",
    ]  # fmt: skip
    assert effects(found, "act") == ["forall(van x) add(Kf, not p(x))", "forall(boat x) add(Kf, not p(x))"]


def test_constants_come_first_and_names_share_one_space(tmp_path):
    given = domain(
        ":parameters (?p ?at-b) :precondition (q ?p ?at-b) :effect (p at-b)", more="(:constants at-b P)"
    )
    found = read(tmp_path, given, problem(objects="a at_b", initial="(p at_b)"))
    assert found.objects == {"at_b": "object", "p_2": "object", "a": "object", "at_b_2": "object"}
    assert found.domain.constants == {"at_b": "object", "p_2": "object"}
    assert [each.name for each in found.domain.actions["act"].parameters] == ["p_3", "at_b_3"]
    assert initial(found)[-1] == "add(Kf, p(at_b_2))"


def test_words_of_kabo_get_a_suffix(tmp_path):
    given = (
        "(define (domain when) (:predicates (then) (add ?k)) (:action true :parameters (?del) :effect (add ?del)))"
    )
    found = read(
        tmp_path, given, "(define (problem xor) (:domain when) (:objects k) (:init (then)) (:goal (then)))"
    )
    assert (found.name, found.domain.name, list(found.domain.actions)) == ("xor_1", "when_1", ["true_1"])
    assert effects(found, "true_1") == ["add(Kf, add_1(del_1))"]


def test_an_object_that_an_action_names_becomes_a_constant(tmp_path):
    found = read(tmp_path, domain(":effect (p b)"), problem())
    assert found.domain.constants == {"b": "object"}


# ------------------------------------------------------------------------------------------------------ conditions
@pytest.mark.parametrize(
    ("condition", "expected"),
    [
        ("()", []), ("(and)", []), ("(and ( ) (and ))", []), ("(r)", ["K(r)"]), ("(not (r))", ["K(not r)"]),
        ("(and (r) (and (p ?x) (p ?y)))", ["K(r)", "K(p(x))", "K(p(y))"]),
        ("(or (r) (or (p ?x) (p ?y)))", ["K(r) or K(p(x)) or K(p(y))"]),
        ("(not (and (r) (not (p ?x))))", ["K(not r) or K(p(x))"]),
        ("(not (or (r) (not (p ?x))))", ["K(not r)", "K(p(x))"]),
        ("(imply (r) (p ?x))", ["K(not r) or K(p(x))"]), ("(not (imply (r) (p ?x)))", ["K(r)", "K(not p(x))"]),
        ("(= ?x ?y)", ["K(x = y)"]), ("(not (= ?x ?y))", ["K(x != y)"]), ("(not (not (r)))", ["K(r)"]),
        ("(forall (?z) (q ?x ?z))", ["forall(object z) K(q(x, z))"]),
        ("(not (forall (?z) (q ?x ?z)))", ["exists(object z) K(not q(x, z))"]),
        ("(exists (?x) (p ?x))", ["exists(object x_2) K(p(x_2))"]),
        ("(forall (?z) (imply (p ?z) (exists (?z) (q ?z ?z))))",
         ["forall(object z) (K(not p(z)) or exists(object z_2) K(q(z_2, z_2)))"]),
        ("(or)", ["false"]), ("(forall () (r))", ["K(r)"]), ("(exists (?z) (and))", ["exists(object z) true"]),
    ],
)  # fmt: skip
def test_conditions_become_queries_with_the_negation_inside(tmp_path, condition, expected):
    found = read(tmp_path, domain(f":parameters (?x ?y) :precondition {condition}"), problem())
    assert preconditions(found, "act") == expected


def test_things_of_different_types_are_never_equal(tmp_path):
    given = domain(
        ":parameters (?x - van ?y - place) :precondition (not (= ?x ?y)) :effect (when (= ?x ?y) (r))",
        more=TYPES, predicates="(r)",
    )  # fmt: skip
    found = read(tmp_path, given, problem(objects="", initial=""))
    assert (preconditions(found, "act"), effects(found, "act")) == ([], [])


# --------------------------------------------------------------------------------------------------------- effects
@pytest.mark.parametrize(
    ("effect", "expected"),
    [
        ("()", []), ("(and)", []), ("(r)", ["add(Kf, r)"]), ("(not (r))", ["add(Kf, not r)"]),
        ("(and (r) (not (p ?x)) (p a))", ["add(Kf, r)", "K(x != a) => add(Kf, not p(x))", "add(Kf, p(a))"]),
        ("(forall (?z) (not (p ?z)))", ["forall(object z) add(Kf, not p(z))"]),
        ("(forall (?z) (when (q ?x ?z) (and (p ?z) (not (q ?x ?z)))))",
         ["forall(object z) (K(q(x, z)) => add(Kf, p(z), not q(x, z)))"]),
        ("(when (or (r) (p ?x)) (p ?y))", ["K(r) or K(p(x)) => add(Kf, p(y))"]),
        ("(when (r) (when (p ?x) (p ?y)))", ["K(r) and K(p(x)) => add(Kf, p(y))"]),
        ("(and (not (r)) (r))", ["add(Kf, r)"]),
        ("(and (r) (forall (?z) (and (not (p ?z)) (when (q ?x ?z) (p ?z)))))",
         ["add(Kf, r)", "forall(object z) (K(not q(x, z)) => add(Kf, not p(z)))",
          "forall(object z) (K(q(x, z)) => add(Kf, p(z)))"]),
    ],
)  # fmt: skip
def test_effects_become_updates_of_what_is_known(tmp_path, effect, expected):
    given = domain(f":parameters (?x ?y) :effect {effect}", more="(:constants a)")
    assert effects(read(tmp_path, given, problem(objects="b")), "act") == expected


def test_an_inequality_in_the_precondition_is_not_asked_again(tmp_path):
    given = domain(":parameters (?x ?y) :precondition (not (= ?y ?x)) :effect (and (not (p ?x)) (p ?y))")
    assert effects(read(tmp_path, given, problem()), "act") == ["add(Kf, not p(x), p(y))"]


# --------------------------------------------------------------------------------------------------------- numbers
NUMBERS = "(:functions (fuel ?v) - number (km ?a ?b) (total-cost) - number limit)".replace(" limit", " (limit)")


def test_numbers_are_compared_and_changed(tmp_path):
    given = domain(
        """:parameters (?x ?y) :precondition (and (>= (fuel ?x) (* 2 (km ?x ?y))) (not (< (limit) 1)) (= (fuel ?y) -1))
        :effect (and (decrease (fuel ?x) (+ (km ?x ?y) 1 .5)) (assign (limit) (- (limit))))""",
        more=NUMBERS,
    )
    found = read(tmp_path, given, problem(initial="(= (fuel a) 10) (= (km a b) 2.5) (= (limit) 3)"))
    assert preconditions(found, "act") == ["K(fuel(x) >= 2 * km(x, y))", "K(limit >= 1)", "K(fuel(y) = -1)"]
    assert effects(found, "act") == ["add(Kf, fuel(x) = fuel(x) - (km(x, y) + 1 + 0.5), limit = 0 - limit)"]
    assert initial(found)[-1] == "add(Kf, fuel(a) = 10, km(a, b) = 2.5, limit = 3)"


def test_changes_of_one_number_add_up(tmp_path):
    given = domain(
        ":parameters (?x) :effect (and (increase (fuel ?x) 2) (r) (decrease (fuel ?x) 1))", more=NUMBERS
    )
    assert effects(read(tmp_path, given, problem()), "act") == ["add(Kf, fuel(x) = fuel(x) + 2 - 1, r)"]


def test_the_metric_makes_costs_of_what_is_added_to_it(tmp_path):
    given = """(define (domain d) (:predicates (p ?x) (r)) (:functions (total-cost) (km ?x))
        (:action go :parameters (?x) :effect (and (p ?x) (increase (total-cost) (km ?x)) (increase (total-cost) 2)))
        (:action free :effect (r)))"""
    more = "(:metric minimize (total-cost))"
    found = read(tmp_path, given, problem(initial="(= (total-cost) 0) (= (km a) 4)", more=more))
    assert [spell(each.cost) for each in found.domain.actions.values()] == ["km(x) + 2", "0"]
    assert effects(found, "go") == ["add(Kf, p(x))"]
    assert list(found.domain.functions) == ["km"]
    assert initial(found)[-1] == "add(Kf, km(a) = 4)"


def test_a_cost_that_a_condition_asks_for_is_also_a_number(tmp_path):
    given = domain(":precondition (< (total-cost) 9) :effect (and (r) (increase (total-cost) 2))", more=NUMBERS)
    more = "(:metric minimize (total-cost))"
    found = read(tmp_path, given, problem(initial="(= (total-cost) 0)", more=more))
    assert effects(found, "act") == ["add(Kf, r, total_cost = total_cost + 2)"]
    assert found.domain.actions["act"].cost.value == 2.0


def test_without_a_metric_every_action_costs_one(tmp_path):
    given = domain(":effect (and (r) (increase (total-cost) 2))", more=NUMBERS)
    found = read(tmp_path, given, problem(initial="(= (total-cost) 0)"))
    assert found.domain.actions["act"].cost.value == 1.0


def test_functions_may_have_objects_as_values(tmp_path):
    given = domain(
        """:parameters (?x ?y) :precondition (and (= (home ?x) ?y) (not (= (home ?y) ?x)))
        :effect (assign (home ?x) (home ?y))""",
        more="(:functions (home ?x) - object)",
    )
    found = read(tmp_path, given, problem(initial="(= (home a) b) (= (home b) b)"))
    assert preconditions(found, "act") == ["K(home(x) = y)", "K(home(y) != x)"]
    assert effects(found, "act") == ["add(Kf, home(x) = home(y))"]
    (finding,) = refused(tmp_path, given, problem(initial="(= (home a) b)"))
    assert finding.message == '"home" has a value for 1 of 2 instances'


# --------------------------------------------------------------------------------------------------- what is refused
@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("(:durative-action x)", "durative actions are not supported (:durative-action)"),
        ("(:derived (p ?x) (r))", "derived predicates are not supported (:derived)"),
        ("(:axiom :vars (?x))", "axioms (derived predicates) are not supported (:axiom)"),
        ("(:constraints (always (r)))", "constraints on the whole plan are not supported (:constraints)"),
        ("(:process x)", "processes are not supported (:process)"),
        ("(:requirements :open-world)",
         'the requirement ":open-world" is not supported: what is not mentioned would be unknown'),
        ("(:predicate (s))", 'unknown section ":predicate" of a domain'),
        ("(:action)", "an action needs a name"), ("word", 'unexpected "word" in a domain'),
        ("(:types a - b b - a)", 'the type "a" is its own supertype'),
        ("(:types a - (either b c))", "a type with several supertypes (either …) is not supported"),
        ("(:types a - b a - c)", 'the type "a" has two supertypes, "b" and "c": not supported'),
        ("(:functions (p ?x))", '"p" is already the name of a predicate'),
        ("(:functions p)", 'unexpected "p", expected "(name …)" or "- type" in (:functions …)'),
        ("(:constants ?x)", '"?x" is a variable, expected the name of a constant'),
        ("(:constants x - (either a b)) (:types a b)",
         '"x" is of several types (either …): not supported for a constant'),
        ("(:constants x - thing)", 'unknown type "thing"'),
        ("(:constants x - )", "a type must follow this hyphen"),
        ("(:constants - object)", "no name stands before this hyphen"),
    ],
)  # fmt: skip
def test_what_a_domain_cannot_have_is_refused_by_name(tmp_path, more, message):
    assert message in [each.message for each in refused(tmp_path, domain(more=more), problem())]


@pytest.mark.parametrize(
    ("part", "message", "hint"),
    [
        (":precondition (pp ?x)", 'unknown predicate "pp" in action "act"', 'did you mean "p"?'),
        (":precondition (p ?z)", 'unknown variable "?z" in action "act"', "there are ?x, ?y"),
        (":precondition (p c)", 'unknown object "c" in action "act"', None),
        (":precondition (p ?x ?y)", "p takes 1 argument, not 2", "p(object) is declared at file_0.pddl:1:"),
        (":precondition (q)", "q takes 2 arguments, not none", None),
        (":precondition (not (r) (r))", '"not" takes one condition, not 2', None),
        (":precondition (imply (r))", '"imply" takes two conditions, not 1', None),
        (":precondition (preference x (r))", 'a preference is not supported in action "act"', None),
        (":precondition (at start (r))", 'a condition with a time is not supported in action "act"', None),
        (":precondition (forall ?z (r))", 'expected "(forall (?x - type …) …)"', None),
        (":precondition (exists (z) (r))", '"z" is no variable', 'write "?z"'),
        (":precondition (exists (?z ?z) (r))", 'the variable "?z" stands twice in this list', None),
        (":precondition (< ?x 3)", '"<" compares numbers, "?x" is none', None),
        (":precondition (> 1 2 3)", '">" compares two things, not 3', None),
        (":effect (= (r) (r))", '"=" is no effect in action "act"', "write (assign (f …) value)"),
        (":effect (when (r))", 'expected "(when condition effect)"', None),
        (":effect (oneof (r) (p ?x))", 'an effect by chance (oneof …) is not supported in action "act"', None),
        (":effect (probabilistic 1/2 (r))", 'a probabilistic effect is not supported in action "act"', None),
        (":effect (increase (p ?x) 1)", '"p" is a predicate: it is true or false, and no value', None),
        (":effect (increase (fool ?x) 1)", 'unknown function "fool" in action "act"', None),
        (":duration (= ?duration 3)", '":duration" of an action is not supported', None),
        (":preconditon (r)", 'unexpected ":preconditon" in an action', 'did you mean ":precondition"?'),
        (":effect", '":effect" has no value', None),
        (":effect (r) :effect (r)", '":effect" stands twice in this action', None),
        (":effect ((r))", 'unexpected "((r))" in action "act", expected "(predicate …)"', None),
    ],
)  # fmt: skip
def test_what_an_action_cannot_have_is_refused_by_name(tmp_path, part, message, hint):
    found = refused(tmp_path, domain(f":parameters (?x ?y) {part}"), problem())
    assert message in [each.message for each in found]
    if hint is not None:
        assert any(hint in (each.hint or "") for each in found)


def test_terms_of_the_wrong_type_are_refused(tmp_path):
    given = domain(
        ":parameters (?x - boat) :precondition (p ?x)", more=TYPES, predicates="(r) (p ?x - (either van lorry))"
    )
    (finding,) = refused(tmp_path, given, problem(objects="", initial=""))
    assert finding.message == 'argument 1 of p must be of type van or lorry, "?x" is of type boat'
    assert (finding.line, finding.column, finding.length) == (1, given.index("(p ?x)") + 4, 2)


@pytest.mark.parametrize(
    ("effects_", "message"),
    [
        ("(when (r) (increase (total-cost) 1))", "a cost that is not simply increased is not supported"),
        ("(decrease (total-cost) 1)", "a cost that is not simply increased is not supported"),
        ("(increase (total-cost) (total-cost))", "a cost that depends on itself is not supported"),
    ],
)
def test_costs_of_other_kinds_are_refused(tmp_path, effects_, message):
    found = refused(
        tmp_path, domain(f":effect {effects_}", more=NUMBERS), problem(more="(:metric minimize (total-cost))")
    )
    assert [each.message for each in found] == [f'{message} in action "act"']


@pytest.mark.parametrize(
    ("metric", "message"),
    [
        ("maximize (total-cost)", 'only "minimize" is supported: kabo\'s costs are added up'),
        ("minimize (total-time)", 'the metric "(total-time)" is not supported'),
        ("minimize (+ (total-cost) (limit))", 'the metric "(+ (total-cost) (limit))" is not supported'),
        ("minimize", 'expected "(:metric minimize (total-cost))"'),
    ],
)
def test_metrics_of_other_kinds_are_refused(tmp_path, metric, message):
    found = refused(tmp_path, domain(more=NUMBERS), problem(more=f"(:metric {metric})"))
    assert [each.message for each in found] == [message]


def test_numbers_that_may_be_changed_twice_are_refused(tmp_path):
    given = domain(":parameters (?x) :effect (and (increase (fuel ?x) 2) (assign (fuel ?x) 1))", more=NUMBERS)
    (finding,) = refused(tmp_path, given, problem())
    assert "is changed twice by this action" in finding.message


def test_numbers_that_may_be_the_same_one_are_warned_of(tmp_path):
    pour = ":parameters (?x ?y) {} :effect (and (decrease (fuel ?x) 1) (increase (fuel ?y) 1))"
    found = warnings(tmp_path, domain(pour.format(""), more=NUMBERS), problem())
    assert [each.message for each in found] == [
        "two effects may change the same value: then the action is not applicable here"
    ]
    assert not warnings(tmp_path, domain(pour.format(":precondition (not (= ?x ?y))"), more=NUMBERS), problem())


def test_names_that_are_not_as_expected_are_warned_of(tmp_path):
    given = domain(more="(:types then) (:constants a-b at_b when p)", predicates="(r) (at-b ?x)")
    found = warnings(tmp_path, given, problem(objects="a_b x", initial="(at-b a_b)"))
    assert [(each.message, each.hint) for each in found] == [
        ('"then" is called "then_1" in kabo and in its plans', '"then" has a meaning of its own'),
        ('"at_b" is called "at_b_2" in kabo and in its plans', '"at_b" is taken by "at-b"'),
        ('"when" is called "when_1" in kabo and in its plans', '"when" has a meaning of its own'),
        ('"a_b" is called "a_b_2" in kabo and in its plans', '"a_b" is taken by "a-b"'),
    ]


def test_an_unknown_type_gives_one_finding(tmp_path):
    given = domain(
        ":parameters (?x - vann) :precondition (p ?x) :effect (forall (?y - vann) (p ?y))", more=TYPES,
        predicates="(r) (p ?x - van)",
    )  # fmt: skip
    found = refused(tmp_path, given, problem(objects="o - vam", initial="(p o)"))
    assert [(each.message, each.hint) for each in found] == [
        ('unknown type "vann"', 'did you mean "van"?'), ('unknown type "vann"', 'did you mean "van"?'),
        ('unknown type "vam"', 'did you mean "van"?'),
    ]  # fmt: skip


@pytest.mark.parametrize(
    "effect",
    ["(and " + "(not (p ?x)) (p ?y) " * 3000 + ")",
     "(and (not (p ?x)) (not (p ?y))" + "".join(f"(p o{n})" for n in range(400)) + ")",
     "(and " + "".join(f"(not (p o{n})) (p o{n + 1})" for n in range(400)) + ")",
     "(and " + "(increase (fuel ?x) 1) " * 3000 + ")", "(when (and " + "(or (r) (p ?x)) " * 50 + ") (p ?y))",
     "(forall (?z) " * 50 + "(p ?z)" + ")" * 50],
    ids=["same", "meetings", "ground", "sums", "cases", "nested"],
)  # fmt: skip
def test_large_effects_are_answered_in_few_calls(tmp_path, effect):
    objects = " ".join(f"o{n}" for n in range(500))
    given = domain(f":parameters (?x ?y) :effect {effect}", more=NUMBERS)
    for initial_ in ("", "(unknown (r)) (unknown (p o1))"):
        asked = problem(objects=objects, initial=initial_)
        assert calls_made(lambda asked=asked: read(tmp_path, given, asked, written=False)) < 4_000_000


def test_all_findings_of_both_files_are_reported_at_once(tmp_path):
    found = refused(tmp_path, domain(":effect (pp)"), problem(initial="(p c)", goal="(s)"))
    assert [(each.file[-11:], each.message) for each in found] == [
        ("file_0.pddl", 'unknown predicate "pp" in action "act"'),
        ("file_1.pddl", 'unknown object "c" in :init'),
        ("file_1.pddl", 'unknown predicate "s" in :goal'),
    ]


def test_unknown_requirements_are_only_warned_of(tmp_path):
    found = warnings(tmp_path, domain(more="(:requirements :strips :adll :time)"), problem())
    assert [(each.severity, each.message) for each in found] == [
        ("warning", 'unknown requirement ":adll": ignored'), ("warning", 'unknown requirement ":time": ignored'),
    ]  # fmt: skip
