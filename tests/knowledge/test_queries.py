"""Queries: compounds, quantifiers, exclusive-or, nested terms; explanations and the relaxation agree with them."""

from hypothesis import given
from hypothesis import strategies as st

from kabo.knowledge import ground
from kabo.knowledge.queries import bits_of, conjunction, disjunction, negation, split
from kabo.language import formulas as f
from tests.knowledge.asking import holds
from tests.support import oracles_knowledge as oracles
from tests.support.small_problems import (
    BELOW,
    COLOUR,
    X,
    Y,
    action,
    add,
    app,
    cmp,
    know,
    lit,
    no,
    problem,
    queries,
    var,
    without_opposites,
)

Q, R = know(lit("q")), know(lit("r"))


def test_or_of_queries_is_not_knowledge_of_the_disjunction():
    assert not holds(f.Or((Q, know(no("q")))))


def test_xor_is_an_exclusive_or_of_queries():
    for initial, expected in [
        ((), False),
        ((lit("q"),), True),
        ((lit("r"),), True),
        ((lit("q"), lit("r")), False),
    ]:
        assert holds(f.Xor(Q, R), initial=[add(fact) for fact in initial]) == expected


def test_a_claim_about_a_term_is_asked_of_its_known_value():
    stacked = {"functions": [BELOW], "initial": [add(cmp(app("below", "x"), "=", "y")), add(lit("p", "y"))]}
    assert holds(know(lit("p", app("below", "x"))), **stacked)
    assert not holds(know(lit("p", app("below", "y"))), **stacked)


def test_terms_are_equal_if_both_values_are_known_and_equal():
    same = know(cmp(app("below", "x"), "=", app("below", "y")))
    differ = know(cmp(app("below", "x"), "!=", app("below", "y")))
    one, other = add(cmp(app("below", "x"), "=", "y")), add(cmp(app("below", "y"), "=", "y"))
    assert holds(same, functions=[BELOW], initial=[one, other])
    assert not holds(same, functions=[BELOW], initial=[one])
    assert not holds(differ, functions=[BELOW], initial=[one])
    excluded = add(cmp(app("below", "y"), "!=", "y"))
    assert holds(differ, functions=[BELOW], initial=[one, excluded])


def test_a_term_equals_itself_whatever_its_value():
    assert holds(know(cmp(app("colour"), "=", app("colour"))), functions=[COLOUR])


def test_objects_are_equal_if_they_have_one_name():
    assert holds(know(cmp(X, "=", X)))
    assert holds(know(cmp(X, "!=", Y)))


def test_geometric_tests_come_last_and_are_asked_only_if_all_else_holds():
    test = f.Test(f.ProcedureCall("is_free", (f.Argument(X),)))
    task = ground(
        problem(goal=(f.And((test, Q)),), initial=[add(lit("r"))], actions=[action("a", effects=[add(lit("q"))])])
    )
    asked = []

    def oracle(call):
        asked.append(str(call))
        return False

    assert not task.is_goal(task.initial, oracle)
    assert asked == []
    assert not task.is_goal(task.actions[0].after(task.initial), oracle)
    assert asked == ["is_free(x)"]


@st.composite
def query_and_states(draw):
    """A formula, and a state reached by random initial knowledge."""
    formula = draw(queries([X, Y], 3))
    facts = draw(
        st.lists(
            st.sampled_from(
                [
                    add(lit("p", "x")),
                    add(no("p", "y")),
                    add(lit("p", "y"), to="Kw"),
                    add(no("q")),
                    add(lit("q")),
                    add(cmp(app("colour"), "=", "u")),
                    add(cmp(app("colour"), "!=", "v")),
                    add(f.TermFact(app("colour")), to="Kv"),
                ]
            ),
            max_size=5,
        )
    )
    changing = action("any", parameters=[var("a")], effects=[add(lit("p", var("a"))), add(no("q"))])
    recolour = action("recolour", effects=[add(cmp(app("colour"), "=", "w"))])
    return problem(
        goal=(formula,), initial=without_opposites(facts), actions=[changing, recolour], functions=[COLOUR]
    )


@given(problem=query_and_states())
def test_queries_hold_exactly_where_the_formula_does(problem):
    """Compared with an evaluator of formula trees that knows nothing of bits."""
    task = ground(problem)
    assert task.is_goal(task.initial) == oracles.goal_holds(problem, oracles.initial_state(problem))


@given(problem=query_and_states(), noise=st.integers(0, 2**40))
def test_a_query_keeps_its_value_while_its_support_does(problem, noise):
    """The explanation of a query is sufficient: other bits do not matter."""
    task = ground(problem)
    query, state = task.goal_query, task.initial
    support = query.support(state)
    assert query.holds(state & support | noise & ~support) == query.holds(state)
    assert support & ~query.reads == 0


@given(problem=query_and_states())
def test_negation_negates_and_what_holds_is_possible(problem):
    """Negation, conjunction and disjunction mean what they say; the relaxation never denies the present."""
    task = ground(problem)
    query, state = task.goal_query, task.initial
    assert negation(query).holds(state) != query.holds(state)
    assert not conjunction([query, negation(query)]).holds(state)
    assert disjunction([query, negation(query)]).holds(state)
    if query.holds(state):
        assert query.possible(state, ~state)
    mask, value, rest = split(query)
    assert (state & mask == value and (rest is None or rest.holds(state))) == query.holds(state)


def test_bits_come_lowest_first():
    assert list(bits_of(0b10110)) == [2, 4, 16]
