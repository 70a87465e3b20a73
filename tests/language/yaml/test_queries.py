"""Formulas: what may not stand in them, and quantifiers."""

import pytest

from tests.language.conftest import Kitchen

WRONG_FORMULAS = [
    ("«grasped(o)»", '"grasped" is a predicate, and a formula is about knowledge', "write K(grasped(o))"),
    ("not «grasped(o)»", '"grasped" is a predicate, and a formula is about knowledge', "write K(grasped(o))"),
    (
        "forall(bottle b) «grasped(b)»",
        '"grasped" is a predicate, and a formula is about knowledge',
        "write K(grasped(b))",
    ),
    ("«pik»(r, o)", 'unknown geometric test "pik" in a precondition of action "pick_up"', 'did you mean "pick"?'),
    ("«always(K(grasped(o)))»", "always(…) may stand only in a goal", None),
    ("«initially(K(grasped(o)))»", "initially(…) may stand only in a goal", None),
    (
        "forall(«bottel» b) K(grasped(b))",
        'unknown type "bottel" in a precondition of action "pick_up"',
        'did you mean "bottle"? bottle is declared at domain.yaml:2:16',
    ),
    (
        "forall(bottle «o») K(grasped(o))",
        '"o" is already the name of a parameter',
        "declared at domain.yaml:19:28; predicates, functions, objects, variables share names",
    ),
    (
        "forall(bottle b, bottle «b») K(grasped(b))",
        '"b" is already the name of a variable',
        "declared at domain.yaml:22:23; predicates, functions, objects, variables share names",
    ),
    ("forall(bottle «B») K(grasped(B))", '"B" cannot be the name of a variable', 'write "b"'),
    (
        "exists(«shelf» b) K(closed)",
        'unknown type "shelf" in a precondition of action "pick_up"',
        '"shelf" is a constant',
    ),
    (
        "exists(bottle b) exists(bottle «b») K(grasped(b))",
        '"b" is already the name of a variable',
        "declared at domain.yaml:22:23; predicates, functions, objects, variables share names",
    ),
    (
        "K(closed) xor K(«open»)",
        'unknown predicate "open" in a precondition of action "pick_up"',
        "there are hand_empty, grasped, robot_grasps, at_location, closed",
    ),
    (
        "forall(bottle b) K(closed) or K(grasped(«b»))",
        'unknown name "b" in a precondition of action "pick_up"',
        'this forall ends before "or"; put parentheses around all that it is about: forall(bottle b) (… or …)',
    ),
    (
        "K(closed) and not exists(bottle b) K(closed) and K(grasped(«b»))",
        'unknown name "b" in a precondition of action "pick_up"',
        'this exists ends before "and"; put parentheses around all that it is about: exists(bottle b) (… and …)',
    ),
    (
        "forall(bottle b) K(closed) and K(closed) or K(grasped(«b»))",
        'unknown name "b" in a precondition of action "pick_up"',
        'this forall ends before "and"; put parentheses around all that it is about: forall(bottle b) (… and …)',
    ),
]


@pytest.mark.parametrize(("new", "message", "hint"), WRONG_FORMULAS, ids=[row[1] for row in WRONG_FORMULAS])
def test_a_wrong_formula_is_reported_at_its_place(
    kitchen: Kitchen, new: str, message: str, hint: str | None
) -> None:
    kitchen.expect("domain", "K(not grasped(o))", new, message, hint)
