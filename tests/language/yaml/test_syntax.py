"""Formulas that do not parse: the place in every style of scalar, and what was meant."""

import pytest

from tests.language.conftest import Kitchen

BROKEN_FORMULAS = [
    (
        "K(grasped(o) «and» hand_empty(r))",
        'unexpected "and", expected ")"',
        "K takes one literal: write K(a) and K(b)",
    ),
    (
        "K(grasped(o) «or» closed)",
        'unexpected "or", expected ")" or "*" or "/" or "+" or "-" or a comparison',
        "K takes one literal: write K(a) or K(b)",
    ),
    ("K(not grasped «o»)", 'unexpected "o", expected "(" or ")"', "write grasped(o)"),
    (
        "content(o) «=» wine",
        'unexpected "=", expected "and" or "or" or "xor" or the end',
        "write K(content(o) = …)",
    ),
    ("fuel «>» 2", 'unexpected ">", expected "("', "write K(fuel > …)"),
    (
        "K(content(o) =«=» wine)",
        'unexpected "=", expected "(" or "+" or "-" or a name or a number',
        'write a single "="',
    ),
    (
        "K(closed(«)»)",
        'unexpected ")", expected "(" or "+" or "-" or a name or a number',
        "without arguments, write closed",
    ),
    ("closed«»", 'unexpected end, expected "("', "write K(closed)"),
    ("closed «and» K(grasped(o))", 'unexpected "and", expected "("', "write K(closed)"),
    ("K(not grasped(o)«»", 'unexpected end, expected ")"', "a parenthesis is not closed"),
    ("K(not grasped(o))«)»", 'unexpected ")", expected the end', None),
    (
        "K(closed) or K(closed) «xor» K(closed)",
        'unexpected "xor", expected "or" or the end',
        "or and xor do not mix without parentheses, and xor takes two",
    ),
    ("forall «b» K(grasped(b))", 'unexpected "b", expected "("', "write forall(type x) …"),
    (
        "K(not grasped(o)) «&» K(closed)",
        'unexpected "&", expected ")" or "=>" or "and" or "or" or "xor"',
        "write and",
    ),
    ("K(«!»grasped(o))", 'unexpected "!", expected "(" or "+" or "-" or "not" or a name or a number', "write not"),
    (
        "K(«K»(grasped(o)))",
        'unexpected "K", expected "(" or "+" or "-" or "not" or a name or a number',
        "a claim about the world stands here, without K",
    ),
    (
        "K(grasped(o)) «implies» K(closed)",
        'unexpected "implies", expected "and" or "or" or "xor" or the end',
        "=> stands only in effects: write not … or …",
    ),
    (
        "K(closed) «=>» K(closed)",
        'unexpected "=>", expected the end',
        "=> stands only in effects: write not … or …",
    ),
    ("K(closed) «|» K(closed)", 'unexpected "|", expected ")" or "=>" or "and" or "or" or "xor"', "write or"),
    ("always«»", 'unexpected end, expected "("', "write K(always)"),
    (
        '"K(not grasped«\\»(o))"',
        "the YAML is broken here: found unknown escape character (while parsing a quoted scalar)",
        None,
    ),
]


@pytest.mark.parametrize(("new", "message", "hint"), BROKEN_FORMULAS, ids=[row[1] for row in BROKEN_FORMULAS])
def test_a_broken_formula_is_reported_at_its_place(
    kitchen: Kitchen, new: str, message: str, hint: str | None
) -> None:
    kitchen.expect("domain", "K(not grasped(o))", new, message, hint)


STYLES = [
    (
        "preconditions: K(«graspd»(o))",
        'unknown predicate "graspd" in a precondition of action "carry"',
        'did you mean "grasped"? grasped(bottle) is declared at domain.yaml:7:3',
    ),
    (
        "preconditions: 'K(«graspd»(o))'",
        'unknown predicate "graspd" in a precondition of action "carry"',
        'did you mean "grasped"? grasped(bottle) is declared at domain.yaml:7:3',
    ),
    (
        'preconditions: "K(«graspd»(o))"',
        'unknown predicate "graspd" in a precondition of action "carry"',
        'did you mean "grasped"? grasped(bottle) is declared at domain.yaml:7:3',
    ),
    (
        "preconditions: >\n        K(grasped(o))\n        and K(«graspd»(o))",
        'unknown predicate "graspd" in a precondition of action "carry"',
        'did you mean "grasped"? grasped(bottle) is declared at domain.yaml:7:3',
    ),
    (
        "preconditions: |\n        K(grasped(o))\n        and K(«graspd»(o))",
        'unknown predicate "graspd" in a precondition of action "carry"',
        'did you mean "grasped"? grasped(bottle) is declared at domain.yaml:7:3',
    ),
    (
        "preconditions: >-\n\n        K(grasped(o)) and\n\n          K(«graspd»(o))\n\n",
        'unknown predicate "graspd" in a precondition of action "carry"',
        'did you mean "grasped"? grasped(bottle) is declared at domain.yaml:7:3',
    ),
    (
        'preconditions: "K(grasped(o))\n        and K(«graspd»(o))"',
        'unknown predicate "graspd" in a precondition of action "carry"',
        'did you mean "grasped"? grasped(bottle) is declared at domain.yaml:7:3',
    ),
    (
        "preconditions: K(grasped(o))\n        and K(«graspd»(o))",
        'unknown predicate "graspd" in a precondition of action "carry"',
        'did you mean "grasped"? grasped(bottle) is declared at domain.yaml:7:3',
    ),
    (
        'preconditions: ["K(robot_grasps(r, o))", K(«graspd»(o))]',
        'unknown predicate "graspd" in a precondition of action "carry"',
        'did you mean "grasped"? grasped(bottle) is declared at domain.yaml:7:3',
    ),
    (
        "preconditions: [«K(robot_grasps(r», o)), K(closed)]",
        "this formula is cut in two: inside [ ] YAML separates at every comma",
        'write one formula a line after "- ", or put it in double quotes',
    ),
    (
        "preconditions:\n      - K(grasped(o))\n      -   K(«graspd»(o))   # why",
        'unknown predicate "graspd" in a precondition of action "carry"',
        'did you mean "grasped"? grasped(bottle) is declared at domain.yaml:7:3',
    ),
]


@pytest.mark.parametrize(("new", "message", "hint"), STYLES, ids=[row[1] for row in STYLES])
def test_the_place_is_exact_in_every_style_of_scalar(
    kitchen: Kitchen, new: str, message: str, hint: str | None
) -> None:
    kitchen.expect("domain", "preconditions:\n      - K(grasped(o))", new, message, hint)
