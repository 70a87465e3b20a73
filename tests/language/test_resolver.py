"""Names, arity and types in terms, atoms and claims: what is wrong, exactly where, and what was meant."""

import pytest

from tests.language.conftest import Kitchen

WRONG_CLAIMS = [
    (
        "K(not «graspd»(o))",
        'unknown predicate "graspd" in a precondition of action "pick_up"',
        'did you mean "grasped"? grasped(bottle) is declared at domain.yaml:7:3',
    ),
    (
        "K(not «robotgrasps»(r, o))",
        'unknown predicate "robotgrasps" in a precondition of action "pick_up"',
        'did you mean "robot_grasps"? robot_grasps(robot, bottle) is declared at domain.yaml:8:3',
    ),
    (
        "K(not «grasped»(r, o))",
        "grasped takes 1 argument, not 2",
        "grasped(bottle) is declared at domain.yaml:7:3",
    ),
    ("K(not «grasped»)", "grasped takes 1 argument, not none", "grasped(bottle) is declared at domain.yaml:7:3"),
    (
        "K(not grasped(«r»))",
        "the argument of grasped must be a bottle, this is a robot",
        "grasped(bottle) is declared at domain.yaml:7:3",
    ),
    (
        "K(not grasped(«oo»))",
        'unknown name "oo" in a precondition of action "pick_up"',
        'did you mean "o"? o is declared at domain.yaml:19:28',
    ),
    (
        "K(grasped(«3»))",
        "the argument of grasped must be a bottle, this is a number",
        "grasped(bottle) is declared at domain.yaml:7:3",
    ),
    (
        "K(content(o) = «beer»)",
        'unknown name "beer" in a precondition of action "pick_up"',
        "content(o) is one of water, wine",
    ),
    (
        "K(«content(o) = shelf»)",
        "these can never be equal: one side is one of {water, wine}, the other a location",
        None,
    ),
    (
        "K(«content»(o))",
        '"content" is a function, not a predicate',
        "write K(content(o) = value), or Kv(content(o)) for whether its value is known",
    ),
    (
        "Kw(«content»(o))",
        '"content" is a function, not a predicate',
        "write K(content(o) = value), or Kv(content(o)) for whether its value is known",
    ),
    ("Kv(«grasped»(o))", '"grasped" is a predicate', "write Kw(grasped(o))"),
    (
        "Kv(«contents»(o))",
        'unknown function "contents" in a precondition of action "pick_up"',
        'did you mean "content"? content(bottle) is declared at domain.yaml:12:3',
    ),
    ("K(«o»)", '"o" is a parameter, not a predicate', None),
    ("K(grasped(«closed»))", '"closed" is a predicate: it is true or false, and no value', None),
    ("K(fuel < «shelf»)", '"<" compares numbers, this is a location', None),
    ("K(«fuel = shelf»)", "these can never be equal: one side is a number, the other a location", None),
    ("K(«r = o»)", "these can never be equal: one side is a robot, the other a bottle", None),
    ("K(fuel = 1 + «o»)", "a number must stand here, this is a bottle", None),
    ("K(«fuel + 1»)", "a predicate must stand here, this is a number", None),
    ("K(grasped(«o»(r)))", '"o" is a parameter and takes no arguments', None),
    ("K(fuel > «1e999»)", "this number is too large", None),
    (
        "K(«speed» > 2)",
        'unknown name "speed" in a precondition of action "pick_up"',
        'did you mean "grasped"? grasped(bottle) is declared at domain.yaml:7:3',
    ),
]


@pytest.mark.parametrize(("new", "message", "hint"), WRONG_CLAIMS, ids=[row[1] for row in WRONG_CLAIMS])
def test_a_wrong_claim_is_reported_at_its_place(
    kitchen: Kitchen, new: str, message: str, hint: str | None
) -> None:
    kitchen.expect("domain", "K(not grasped(o))", new, message, hint)


WRONG_CALLS = [
    ("«pik»(r, o)", 'unknown procedure "pik" in `geometry` of action "pick_up"', 'did you mean "pick"?'),
    ("«pick»(r)", 'pick lacks "object"', "it is pick(robot, object, grasp = …)"),
    ("«pick»(r, o, side, o)", "pick takes at most 3 arguments", "it is pick(robot, object, grasp = …)"),
    ("pick(r, o, «grip = side»)", 'pick has no property "grip"', 'did you mean "grasp"?'),
    ("pick(r, o, «grasp = 3»)", 'the property "grasp" takes a name, not a number', None),
    ("pick(r, o, grasp = «sides»)", 'the scene has no grasp family "sides"', 'did you mean "side"?'),
    (
        "pick(r, «oo», grasp = side)",
        '"oo" is no body of the scene; pick(r, oo, grasp = side) at domain.yaml:23:15 needs a body',
        "there are table, tray, bottle_1",
    ),
    ("pick(r, o, side, «grasp = side»)", '"grasp" is given twice', None),
    ("pick(object = o, «r»)", "arguments by position stand before those by name", None),
    ("pick(r, «grasped»)", '"grasped" is a predicate, and no argument of a procedure', None),
    ("pick(r, o, grasp«»", 'unexpected end, expected ")" or "," or "="', "a parenthesis is not closed"),
    (
        "place(r, o, «tabel»)",
        '"tabel" is no region of the scene; place(r, o, tabel) at domain.yaml:23:15 needs a region',
        "there are shelf",
    ),
]


@pytest.mark.parametrize(("new", "message", "hint"), WRONG_CALLS, ids=[row[1] for row in WRONG_CALLS])
def test_a_wrong_procedure_call_is_reported_at_its_place(
    kitchen: Kitchen, new: str, message: str, hint: str | None
) -> None:
    kitchen.expect("domain", "pick(r, o, grasp = side)", new, message, hint)
