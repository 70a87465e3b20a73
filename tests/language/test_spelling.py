"""Formulas as text, and back."""

import pytest

from kabo.language import formulas as f
from kabo.language import spell, spell_number
from tests.language.trees import parse_text

FORMULAS = [
    "K(grasped(o))",
    "K(not grasped(o))",
    "not K(closed)",
    "Kw(closed)",
    "Kv(content(o))",
    "K(content(o) = wine)",
    "K(content(o) != wine)",
    "K(fuel >= 2 * fuel + 1)",
    "K(fuel > (fuel + 1) * 2)",
    "K(fuel > fuel - (fuel - 1))",
    "K(fuel < fuel / (2 * fuel))",
    "K(fuel < -2.5)",
    "K(fuel < 0 - fuel)",
    "true or false",
    "pick(r, o)",
    "K(closed) and Kw(closed) or not (K(closed) or Kw(closed))",
    "(K(closed) or Kw(closed)) and K(closed)",
    "(K(closed) and Kw(closed)) and K(closed)",
    "K(closed) xor K(closed) and Kw(closed)",
    "(K(closed) xor Kw(closed)) or K(closed)",
    "forall(bottle b) (K(grasped(b)) or exists(robot s, location l) K(robot_grasps(s, b)))",
    "forall(bottle b) not K(grasped(b))",
    "initially(K(closed)) and always(K(closed) or Kw(closed))",
]

EFFECTS = [
    "add(Kf, closed, not grasped(o), content(o) = wine, content(o) != water)",
    "del(Kf, closed)",
    "add(Kw, closed, closed and grasped(o))",
    "add(Kv, content(o), fuel)",
    "add(Kx, closed, not grasped(o), content(o) = wine)",
    "add(Kx, exactly_one(bottle b) grasped(b))",
    "add(LCW, forall(bottle b) (grasped(b) and closed))",
    "add(Kf, forall(bottle b) not grasped(b), closed)",
    "add(Kf, forall(bottle b, robot s) (grasped(b) and robot_grasps(s, b)))",
    "K(closed) => add(Kf, grasped(o)), del(Kf, closed)",
    "K(closed) or Kw(closed) => add(Kf, grasped(o))",
    "forall(bottle b) add(Kf, grasped(b))",
    "forall(bottle b) (K(closed) => add(Kf, grasped(b)), del(Kf, closed))",
    "forall(bottle b) (add(Kf, grasped(b)), del(Kf, closed))",
    "when closed and content(o) = wine then grasped(o) and not closed",
    "add(Kf, fuel = fuel - 1), del(Kf, closed)",
]


@pytest.mark.parametrize("text", FORMULAS)
def test_a_formula_is_spelled_as_it_was_written(text: str) -> None:
    assert spell(parse_text(text)) == text


@pytest.mark.parametrize("text", EFFECTS)
def test_an_effect_is_spelled_as_it_was_written(text: str) -> None:
    assert ", ".join(map(spell, parse_text(text, "effect"))) == text


@pytest.mark.parametrize("text", FORMULAS)
def test_blanks_line_breaks_and_comments_do_not_count(text: str) -> None:
    spread = text.replace("(", " (\n  ").replace(",", " ,\r\n").replace(")", "\t) ")
    assert parse_text(f"  {spread}  # so") == parse_text(text)


def test_atoms_and_calls_are_spelled_as_plans_show_them() -> None:
    bottle = f.Constant("bottle_1")
    assert spell(f.Atom("empty_bottle", (bottle,))) == "empty_bottle(bottle_1)"
    assert spell(f.Atom("has_note")) == "has_note"
    assert spell(f.Application("at", (bottle, f.Number(2.0)))) == "at(bottle_1, 2)"
    grasp = f.Argument(f.Constant("side"), "grasp")
    assert spell(f.ProcedureCall("pick", (f.Argument(bottle), grasp))) == "pick(bottle_1, grasp = side)"


@pytest.mark.parametrize(
    ("value", "text"), [(2.0, "2"), (0.5, "0.5"), (-3.0, "-3"), (1e-07, "1e-07"), (1e22, "1e+22"), (0.1, "0.1")]
)
def test_numbers_are_spelled_shortly_and_exactly(value: float, text: str) -> None:
    assert spell_number(value) == text
    assert float(text) == value


def test_only_trees_of_the_language_have_a_spelling() -> None:
    with pytest.raises(TypeError, match="dict is no formula"):
        spell({})
