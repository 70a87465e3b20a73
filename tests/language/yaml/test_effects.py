"""Effects: which database takes what, and where conditions and world effects may stand."""

import pytest

from tests.language.conftest import Kitchen

WRONG_EFFECTS = [
    ("add(«Kg», closed)", 'unexpected "Kg", expected Kf, Kw, Kv, Kx, Kor or LCW', None),
    (
        "add(Kf, «K»(closed))",
        'unexpected "K", expected "(" or "+" or "-" or "exactly_one" or "forall" or "not" or …',
        "a claim about the world stands here, without K",
    ),
    (
        "add(Kf, «closed and grasped(o)»)",
        "Kf takes literals, f = v and f != v, not this",
        "write the facts as several: Kf, a, b",
    ),
    (
        "add(Kw, «not closed»)",
        "Kw takes atoms and conjunctions, not this",
        "whether p and whether not p are the same: write the atom",
    ),
    ("add(Kw, «fuel = 3»)", "Kw takes atoms and conjunctions, not this", None),
    (
        "add(Kw, closed and «fuel = 3»)",
        "Kw takes atoms and conjunctions, not this",
        "for what value it has, write add(Kv, f(x))",
    ),
    ("add(Kv, «closed»)", '"closed" is a predicate', "write Kw(closed)"),
    ("add(Kv, «not closed»)", "Kv takes function terms, not this", None),
    (
        "add(Kx, «forall(bottle b) grasped(b)»)",
        "Kx takes literals, f = v, or exactly_one(type x) …, not this",
        None,
    ),
    ("add(Kf, «exactly_one(bottle b) grasped(b)»)", "Kf takes literals, f = v and f != v, not this", None),
    ("add(Kf, «fuel < 3»)", 'a fact here has the form f = v, not "<"', None),
    ("add(Kx, «fuel != 3»)", 'a fact here has the form f = v, not "!="', None),
    ("add(Kf, «3 = fuel»)", "a fact about a value must have the function on its left", "write it on the left"),
    ("add(Kf, «r = r»)", "a fact about a value must have the function on its left", None),
    (
        "add(Kf, content(o) = «content_of»(o))",
        'unknown function "content_of" in an effect of action "pick_up"',
        'did you mean "content"? content(bottle) is declared at domain.yaml:12:3',
    ),
    ("add(Kf, «home_of(o) = o»)", "these can never be equal: one side is a location, the other a bottle", None),
    ("add(Kf, fuel = fuel - «o»)", "a number must stand here, this is a bottle", None),
    ("when closed then «fuel != 2»", 'a fact here has the form f = v, not "!="', None),
    (
        "forall(bottle b) K(grasped(b)) => add(Kf, grasped(«b»))",
        'unknown name "b" in an effect of action "pick_up"',
        '"b" is bound on the left only: write forall(bottle b) (condition => add(…)) to have it on both sides',
    ),
    (
        "forall(bottle b) forall(bottle c) «add»(Kf, grasped(b))",
        'unexpected "add", expected "(" or "exists" or "false" or "forall" or "k" or …',
        "write forall(type x, other y) add(…) or forall(type x) (condition => add(…))",
    ),
    ("K(closed) «then» add(Kf, closed)", 'unexpected "then", expected "=>" or "and" or "or" or "xor"', None),
    (
        "K(closed) «-»> add(Kf, closed)",
        'unexpected "-", expected "=>" or "and" or "or" or "xor"',
        "write condition => add(…)",
    ),
    ("grasped(o)«»", 'unexpected end, expected "=>"', "write add(Kf, grasped(o))"),
    ("K(closed) => add(Kf, closed) «and» add(Kf, closed)", 'unexpected "and", expected "," or the end', None),
]


@pytest.mark.parametrize(("new", "message", "hint"), WRONG_EFFECTS, ids=[row[1] for row in WRONG_EFFECTS])
def test_a_wrong_effect_is_reported_at_its_place(
    kitchen: Kitchen, new: str, message: str, hint: str | None
) -> None:
    kitchen.expect("domain", "K(closed) => del(Kf, closed)", new, message, hint)


WRONG_RULES = [
    (
        "«when closed then closed»",
        "`when … then …` is an effect of actions and may not stand in an update rule",
        None,
    ),
    ("K(grasped(«b»)) => add(Kf, closed)", 'unknown name "b" in an update rule', None),
]


@pytest.mark.parametrize(("new", "message", "hint"), WRONG_RULES, ids=[row[1] for row in WRONG_RULES])
def test_a_wrong_update_rule_is_reported_at_its_place(
    kitchen: Kitchen, new: str, message: str, hint: str | None
) -> None:
    kitchen.expect(
        "domain", "forall(bottle b) (K(grasped(b)) => add(Kf, not at_location(b, shelf)))", new, message, hint
    )


WRONG_INITIAL = [
    (
        "«when closed then closed»",
        "`when … then …` is an effect of actions and may not stand in the initial knowledge",
        None,
    ),
    (
        "«K(closed) => add(Kf, closed)»",
        "an effect in the initial knowledge cannot be conditional: nothing is known before",
        None,
    ),
    (
        "forall(bottle b) («K(closed) => add(Kf, closed)»)",
        "an effect in the initial knowledge cannot be conditional: nothing is known before",
        None,
    ),
    (
        "add(Kf, grasped(«left»))",
        "the argument of grasped must be a bottle, this is a robot",
        "grasped(bottle) is declared at domain.yaml:7:3",
    ),
    (
        "add(Kf, grasped(«bottle1»))",
        'unknown name "bottle1" in the initial knowledge',
        'did you mean "bottle_1"? bottle_1 is declared at problem.yaml:6:12',
    ),
]


@pytest.mark.parametrize(("new", "message", "hint"), WRONG_INITIAL, ids=[row[1] for row in WRONG_INITIAL])
def test_a_wrong_initial_update_is_reported_at_its_place(
    kitchen: Kitchen, new: str, message: str, hint: str | None
) -> None:
    kitchen.expect("problem", "add(Kf, hand_empty(left), fuel = 2)", new, message, hint)
