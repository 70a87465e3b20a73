"""Domain files: declarations, actions, and one namespace for all names."""
# ruff: noqa: E501 (messages stand on one line, as they are printed)

import pytest

from tests.language.conftest import Kitchen

WRONG_DECLARATIONS = [
    (
        "domain: bar",
        "domain: «Bar»",
        '"Bar" cannot be the name of a domain',
        'write "bar": names match [a-z][a-z0-9_]*',
    ),
    ("domain: bar", "«domain»:", 'the key "domain" of a domain has no value', None),
    (
        "types: [robot, bottle, location]",
        "types: [robot, bottle, location, «robot»]",
        'the type "robot" is declared twice',
        "first in line 2",
    ),
    (
        "types: [robot, bottle, location]",
        "types: [robot, bottle, location, «Robot»]",
        '"Robot" cannot be the name of a type',
        'write "robot": names match [a-z][a-z0-9_]*',
    ),
    (
        "types: [robot, bottle, location]",
        "types: [robot, bottle, location, «number»]",
        '"number" is built in and cannot be the name of a type',
        None,
    ),
    (
        "types: [robot, bottle, location]",
        "types: {robot: , bottle: , location: , «1»: }",
        '"1" cannot be the name of a type',
        'write "n1": names match [a-z][a-z0-9_]*',
    ),
    (
        "types: [robot, bottle, location]",
        "types: {robot: , bottle: , location: {shop: , «robot»: }}",
        'the type "robot" is declared twice',
        "first in line 2",
    ),
    (
        "  location: [shelf]",
        "  location: [shelf, «shelf»]",
        '"shelf" is already the name of a constant',
        "declared at domain.yaml:4:14; predicates, functions, objects, variables share names",
    ),
    (
        "  location: [shelf]",
        "  «locaton»: [nook]\n  location: [shelf]",
        'unknown type "locaton" of constants',
        'did you mean "location"? location is declared at domain.yaml:2:24',
    ),
    (
        "  location: [shelf]",
        "  location: [shelf, «isHere»]",
        '"isHere" cannot be the name of a constant',
        'write "is_here": names match [a-z][a-z0-9_]*',
    ),
    (
        "  closed: []",
        "  «isClosed»: []\n  closed: []",
        '"isClosed" cannot be the name of a predicate',
        'write "is_closed": names match [a-z][a-z0-9_]*',
    ),
    (
        "  closed: []",
        "  «when»: []\n  closed: []",
        '"when" is a word of the language and cannot be the name of a predicate',
        None,
    ),
    (
        "  closed: []",
        "  «shelf»: []\n  closed: []",
        '"shelf" is already the name of a constant',
        "declared at domain.yaml:4:14; predicates, functions, objects, variables share names",
    ),
    (
        "  closed: []",
        "  closed: []\n  «closed»: [robot]",
        'duplicate key "closed"',
        "it stands already in line 10",
    ),
    (
        "  closed: []",
        "  closed: []\n  p: [«robbot»]",
        'unknown type "robbot" of the predicate "p"',
        'did you mean "robot"? robot is declared at domain.yaml:2:9',
    ),
    (
        "value: number}",
        "value: «numbr»}",
        'unknown type "numbr" as the value of the function "fuel"',
        'did you mean "number"?',
    ),
    (
        "value: [water, wine]}",
        "value: [water, wine, «water»]}",
        'the value "water" stands twice in the list of the function "content"',
        None,
    ),
    (
        "value: [water, wine]}",
        "value: [water, wine, «shelf»]}",
        '"shelf" is already the name of a constant',
        "declared at domain.yaml:4:14; predicates, functions, objects, variables share names",
    ),
    (
        "  fuel: {arguments: [], value: number}",
        "  fuel: {arguments: [], value: number}\n  «speed»: {arguments: []}",
        'the function "speed" needs the key "value"',
        None,
    ),
    (
        "  fuel: {arguments: [], value: number}",
        "  fuel: {arguments: [], value: number, «args»: []}",
        'unknown key "args" of the function "fuel"',
        'did you mean "arguments"?',
    ),
    ("update_rules:", "«update_rule»:", 'unknown key "update_rule" of a domain', 'did you mean "update_rules"?'),
    (
        "  pick_up:",
        "  «pickUp»:",
        '"pickUp" cannot be the name of an action',
        'write "pick_up": names match [a-z][a-z0-9_]*',
    ),
    ("  carry:", "  nap: «[a]»\n  carry:", 'the action "nap" must be a mapping: `name: value`, one a line', None),
]


@pytest.mark.parametrize(
    ("old", "new", "message", "hint"), WRONG_DECLARATIONS, ids=[row[2] for row in WRONG_DECLARATIONS]
)
def test_a_wrong_declaration_is_reported_at_its_place(
    kitchen: Kitchen, old: str, new: str, message: str, hint: str | None
) -> None:
    kitchen.expect("domain", old, new, message, hint)


WRONG_ACTIONS = [
    (
        "    sense: content(o)",
        "    sense: «contents»(o)",
        'unknown predicate or function "contents" in `sense` of action "pick_up"',
        'did you mean "content"? content(bottle) is declared at domain.yaml:12:3',
    ),
    (
        "    sense: content(o)",
        "    sense: «K»(closed)",
        'unexpected "K", expected "(" or "+" or "-" or a name or a number',
        None,
    ),
    ("    sense: content(o)", "    sense: «o»", '"o" is a parameter, not a predicate', None),
    (
        "    sense: content(o)",
        "    sense: content(«r»)",
        "the argument of content must be a bottle, this is a robot",
        "content(bottle) is declared at domain.yaml:12:3",
    ),
    ("    cost: fuel + 1", "    cost: fuel + «r»", "a number must stand here, this is a robot", None),
    ("    cost: fuel + 1", "    cost: «r»", "a cost must be a number", None),
    ("    cost: fuel + 1", "    cost: «1e999»", "this number is too large", None),
    (
        "    cost: fuel + 1",
        "    «costs»: 1",
        'unknown key "costs" of the action "pick_up"',
        'did you mean "cost"?',
    ),
    ("    cost: fuel + 1", "    cost: «content(o)»", "a cost must be a number", None),
    (
        "    parameters: {r: robot, o: bottle}\n    preconditions:\n      - K(hand",
        "    parameters: {r: robot, o: «bottel»}\n    preconditions:\n      - K(hand",
        'unknown type "bottel" in the parameters of action "pick_up"',
        'did you mean "bottle"? bottle is declared at domain.yaml:2:16',
    ),
    (
        "    parameters: {r: robot, o: bottle}\n    preconditions:\n      - K(hand",
        "    parameters: {r: robot, o: bottle, «shelf»: robot}\n    preconditions:\n      - K(hand",
        '"shelf" is already the name of a constant',
        "declared at domain.yaml:4:14; predicates, functions, objects, variables share names",
    ),
    (
        "    parameters: {r: robot, o: bottle}\n    preconditions:\n      - K(hand",
        "    parameters: {r: robot, o: bottle, «r'»: robot}\n    preconditions:\n      - K(hand",
        '"r\'" cannot be the name of a parameter',
        'write "r_prime": names match [a-z][a-z0-9_]*',
    ),
    (
        "    parameters: {r: robot, o: bottle}\n    preconditions:\n      - K(hand",
        "    parameters: {r: robot, o: bottle, c: {value_of: «closed»}}\n    preconditions:\n      - K(hand",
        '"closed" is a predicate',
        "write Kw(closed)",
    ),
    (
        "    parameters: {r: robot, o: bottle}\n    preconditions:\n      - K(hand",
        "    parameters: {r: robot, o: bottle, c: {«valueof»: fuel, value_of: fuel}}\n    preconditions:\n      - K(hand",
        'unknown key "valueof" of a run-time variable',
        'did you mean "value_of"?',
    ),
    (
        "transfer(r, o, shelf, keep = upright)",
        "transfer(r, o, shelf, keep = «uprigt»)",
        'the scene has no motion constraint "uprigt"',
        'did you mean "upright"?',
    ),
    (
        "transfer(r, o, shelf, keep = upright)",
        "transfer(r, o, «table», keep = upright)",
        '"table" is a body of the scene; transfer(r, o, table, keep = upright) at domain.yaml:33:15 needs a region',
        "there are shelf",
    ),
    (
        "    preconditions:\n      - K(grasped(o))",
        "    «precondition»: K(grasped(o))",
        'unknown key "precondition" of the action "carry"',
        'did you mean "preconditions"?',
    ),
    (
        "    preconditions:\n      - K(grasped(o))",
        "    preconditions:\n      -«»",
        'a precondition of action "carry" is missing after the dash',
        None,
    ),
    (
        "    preconditions:\n      - K(grasped(o))",
        "    preconditions:\n      - «K(grasped(o)): 3»",
        'a precondition of action "carry" must be text, this is a mapping',
        'a formula that contains ": " must stand in double quotes',
    ),
    (
        "    preconditions:\n      - K(grasped(o))",
        "    preconditions: «{K(grasped(o)): }»",
        'a precondition of action "carry" must be a list',
        None,
    ),
]


@pytest.mark.parametrize(("old", "new", "message", "hint"), WRONG_ACTIONS, ids=[row[2] for row in WRONG_ACTIONS])
def test_a_wrong_action_is_reported_at_its_place(
    kitchen: Kitchen, old: str, new: str, message: str, hint: str | None
) -> None:
    kitchen.expect("domain", old, new, message, hint)
