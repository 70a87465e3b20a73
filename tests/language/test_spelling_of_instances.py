"""Formulas as text stand in the language's own spelling."""

from kabo.language import formulas as f
from kabo.language import spell_bound
from tests.support.small_problems import app, atom, cmp, know, lit, no, var

Z = var("z")


def test_formulas_are_spelt_as_in_the_files():
    tree = f.Forall((Z,), f.Xor(f.And((know(lit("p", Z)), f.Not(know(no("q"))))), f.KnowWhether(atom("p", Z))))
    assert spell_bound(tree, {}) == "forall(thing z) ((K(p(z)) and not K(not q)) xor Kw(p(z)))"


def test_bound_variables_are_replaced():
    assert spell_bound(f.Or((know(lit("p", Z)), f.KnowValue(app("f", Z)))), {"z": "x"}) == "K(p(x)) or Kv(f(x))"


def test_numbers_and_sums_can_be_read():
    claim = cmp(app("fuel"), ">=", f.Arithmetic("*", f.Number(2.0), app("d")))
    assert spell_bound(know(claim), {}) == "K(fuel >= (2 * d))"
    assert spell_bound(f.Exists((Z,), f.Truth(True)), {}) == "exists(thing z) true"


def test_a_geometric_test_keeps_the_variables_that_are_not_bound():
    free = f.Test(f.ProcedureCall("is_free", (f.Argument(Z),)))
    assert spell_bound(f.Exists((Z,), free), {}) == "exists(thing z) is_free(z)"
    assert spell_bound(free, {"z": "x"}) == "is_free(x)"
