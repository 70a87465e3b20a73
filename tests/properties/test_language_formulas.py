"""Round trip: what a tree is spelled as parses to an equal tree, whatever the tree."""

from typing import Any

from hypothesis import event, given
from hypothesis import strategies as st

from kabo.language import formulas as f
from kabo.language import spell
from tests.language.trees import parse_text

ROBOT, BOTTLE, SHELF = f.Variable("r", "robot"), f.Variable("o", "bottle"), f.Constant("shelf")
CONTENT, FUEL = f.Application("content", (BOTTLE,)), f.Application("fuel")

atoms = st.sampled_from(
    [
        f.Atom("closed"),
        f.Atom("hand_empty", (ROBOT,)),
        f.Atom("grasped", (BOTTLE,)),
        f.Atom("at_location", (BOTTLE, SHELF)),
        f.Atom("at_location", (BOTTLE, f.Application("home_of", (BOTTLE,)))),
    ]
)
literals = st.builds(f.Literal, atoms, st.booleans())
numbers = st.one_of(
    st.integers(-20, 20).map(float),
    st.floats(allow_nan=False, allow_infinity=False).map(lambda value: value + 0.0),
).map(f.Number)
sums = st.recursive(
    st.one_of(numbers, st.just(FUEL)),
    lambda inner: st.builds(f.Arithmetic, st.sampled_from("+-*/"), inner, inner),
    max_leaves=6,
)
comparisons = st.one_of(
    st.builds(f.Comparison, st.sampled_from(["=", "!=", "<", "<=", ">", ">="]), sums, sums),
    st.builds(
        f.Comparison,
        st.sampled_from(["=", "!="]),
        st.just(CONTENT),
        st.sampled_from([f.Constant("wine"), CONTENT]),
    ),
)
queries = st.one_of(
    st.builds(f.Know, st.one_of(literals, comparisons)),
    st.builds(f.KnowWhether, atoms),
    st.sampled_from([f.KnowValue(CONTENT), f.KnowValue(FUEL), f.Truth(True), f.Truth(False)]),
    st.just(f.Test(f.ProcedureCall("pick", (f.Argument(ROBOT), f.Argument(BOTTLE))))),
)


def _deeper(inner: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    several = st.lists(inner, min_size=2, max_size=3).map(tuple)
    return st.one_of(
        st.builds(f.And, several),
        st.builds(f.Or, several),
        st.builds(f.Xor, inner, inner),
        st.builds(f.Not, inner),
        st.builds(f.Temporal, st.sampled_from(["initially", "always"]), inner),
    )


formulas = st.recursive(queries, _deeper, max_leaves=8)
quantified = st.builds(
    lambda quantifier, body: quantifier((f.Variable("x", "bottle"), f.Variable("y", "robot")), body),
    st.sampled_from([f.Forall, f.Exists]),
    formulas,
)


@given(tree=st.one_of(formulas, quantified))
def test_a_formula_survives_being_spelled_and_parsed(tree: Any) -> None:
    event(f"outermost: {type(tree).__name__}")
    assert parse_text(spell(tree)) == tree


facts = st.one_of(literals, st.builds(f.Comparison, st.just("="), st.just(FUEL), sums))
changes = st.one_of(
    st.builds(
        f.Change,
        st.sampled_from(["add", "del"]),
        st.just("Kf"),
        st.lists(facts, min_size=1, max_size=3).map(tuple),
    ),
    st.builds(f.Change, st.just("add"), st.just("Kw"), st.tuples(st.builds(f.Literal, atoms))),
    st.just(f.Change("add", "Kv", (f.TermFact(CONTENT),))),
    st.builds(
        lambda body: f.Change("add", "Kx", (f.ExactlyOne((f.Variable("z", "bottle"),), body),)),
        st.just(f.Literal(f.Atom("grasped", (f.Variable("z", "bottle"),)))),
    ),
    st.builds(f.WorldEffect, st.lists(facts, min_size=1, max_size=2).map(tuple), st.tuples(facts)),
)
conditionals = st.builds(f.Conditional, queries, st.lists(changes, min_size=1, max_size=2).map(tuple))
effects = st.one_of(
    changes,
    conditionals,
    st.builds(
        f.ForEach,
        st.just((f.Variable("x", "bottle"),)),
        st.one_of(st.lists(changes, min_size=1, max_size=2).map(tuple), st.tuples(conditionals)),
    ),
)


@given(tree=effects)
def test_an_effect_survives_being_spelled_and_parsed(tree: Any) -> None:
    event(f"outermost: {type(tree).__name__}")
    assert parse_text(spell(tree), "effect") == (tree,)
