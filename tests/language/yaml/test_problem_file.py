"""Problem files: objects and the things they are, options, goal."""
# ruff: noqa: E501 (messages stand on one line, as they are printed)

import pytest

from tests.language.conftest import Kitchen

WRONG_PROBLEMS = [
    (
        "domain: domain.yaml",
        "domain: «domian.yaml»",
        '"domian.yaml": there is no such file',
        'did you mean "domain.yaml"?',
    ),
    (
        "domain: domain.yaml",
        "domain: «scene.yaml»",
        "scene.yaml is no domain: it has none of the keys of one",
        None,
    ),
    (
        "scene: scene.yaml",
        "scene: «scenes.yaml»",
        '"scenes.yaml": there is no such file',
        'did you mean "scene.yaml"?',
    ),
    ("scene: scene.yaml", "scene: «.»", '".": this is a folder, not a file', None),
    (
        "scene: scene.yaml",
        "scene: «domain.yaml»",
        "domain.yaml is no scene: it has none of the keys of one",
        None,
    ),
    (
        "  robot: [left]",
        "  robot: [left, «right»]",
        '"right" is no robot of the scene; pick(r, o, grasp = side) at domain.yaml:23:15 needs a robot',
        "there are left",
    ),
    (
        "  robot: [left]",
        "  robot: [left, «table»]",
        '"table" is a body of the scene; pick(r, o, grasp = side) at domain.yaml:23:15 needs a robot',
        "there are left",
    ),
    (
        "  robot: [left]",
        "  robot: [left, «Right»]",
        '"Right" cannot be the name of an object',
        'write "right": names match [a-z][a-z0-9_]*',
    ),
    (
        "  robot: [left]",
        "  robot: [left, «left»]",
        '"left" is already the name of an object',
        "declared at problem.yaml:5:11; predicates, functions, objects, variables share names",
    ),
    (
        "  robot: [left]",
        "  robot: [left]\n  «bottel»: [b2]",
        'unknown type "bottel" of objects',
        'did you mean "bottle"? bottle is declared at domain.yaml:2:16',
    ),
    (
        "  robot: [left]",
        "  robot: [left, «closed»]",
        '"closed" is already the name of a predicate',
        "declared at domain.yaml:10:3; predicates, functions, objects, variables share names",
    ),
    (
        "  robot: [left]",
        "  robot: [left]\n  «robot»: [left]",
        'duplicate key "robot"',
        "it stands already in line 5",
    ),
    (
        "  bottle: [bottle_1]",
        "  bottle: [bottle_1, «tabel»]",
        '"tabel" is no body of the scene; pick(r, o, grasp = side) at domain.yaml:23:15 needs a body',
        'did you mean "table"?',
    ),
    (
        "  bottle: [bottle_1]",
        "  bottle: [bottle_1, «shelf»]",
        '"shelf" is already the name of a constant',
        "declared at domain.yaml:4:14; predicates, functions, objects, variables share names",
    ),
    (
        "K(grasped(bottle_1)) or K(content(bottle_1) = wine)",
        "K(grasped(«bottle_2»))",
        'unknown name "bottle_2" in the goal',
        'did you mean "bottle_1"? bottle_1 is declared at problem.yaml:6:12',
    ),
    (
        "K(grasped(bottle_1)) or K(content(bottle_1) = wine)",
        "K(«graspd»(bottle_1))",
        'unknown predicate "graspd" in the goal',
        'did you mean "grasped"? grasped(bottle) is declared at domain.yaml:7:3',
    ),
    (
        "K(grasped(bottle_1)) or K(content(bottle_1) = wine)",
        "always(K(«graspd»(bottle_1)))",
        'unknown predicate "graspd" in the goal',
        'did you mean "grasped"? grasped(bottle) is declared at domain.yaml:7:3',
    ),
    (
        "search: breadth-first",
        "search: «breadthfirst»",
        '`search` must be one of best, greedy, astar, breadth-first, depth-first, iterative-deepening, not "breadthfirst"',
        'did you mean "breadth-first"?',
    ),
    ("seed: 3", "seed: «-1»", '`seed` must be a whole number from 0 on, not "-1"', None),
    ("seed: 3", "seed: «three»", '`seed` must be a whole number from 0 on, not "three"', None),
    ("seed: 3", "seed: «1.5»", '`seed` must be a whole number from 0 on, not "1.5"', None),
    ("seed: 3", "«sed»: 1", 'unknown key "sed" of `options`', 'did you mean "seed"?'),
    ("seed: 3", "epsilon: «0»", "`epsilon` must be greater than 0", None),
    (
        "seed: 3",
        "geometry: «meshes»",
        '`geometry` must be one of bounding, exact, none, not "meshes"',
        "there are bounding, exact, none",
    ),
    ("{seconds: 10}", "{seconds: «0»}", "`seconds` must be greater than 0", None),
    ("{seconds: 10}", "{«second»: 10}", 'unknown key "second" of `budget`', 'did you mean "seconds"?'),
    ("{seconds: 10}", "{expansions: «0»}", '`expansions` must be a whole number from 1 on, not "0"', None),
    (
        "problem: one_bottle",
        "problem: one_bottle\n«gaol»: x",
        'unknown key "gaol" of a problem',
        'did you mean "goal"?',
    ),
    (
        "problem: one_bottle",
        "problem: «oneBottle»",
        '"oneBottle" cannot be the name of a problem',
        'write "one_bottle": names match [a-z][a-z0-9_]*',
    ),
    ("goal:\n", "«goal»:\n#", 'the key "goal" of a problem has no value', None),
    ("model: bottle", "model: «bottel»", 'unknown model "bottel"', 'did you mean "bottle"?'),
    ("frame: table", "frame: «tabel»", 'unknown frame "tabel" of "bottle_1"', 'did you mean "table"?'),
    (
        "frame: table",
        "frame: «bottle_1»",
        "the frames form a circle: bottle_1 → bottle_1",
        "give one of them a pose in the frame of something else",
    ),
]


@pytest.mark.parametrize(("old", "new", "message", "hint"), WRONG_PROBLEMS, ids=[row[2] for row in WRONG_PROBLEMS])
def test_a_wrong_problem_is_reported_at_its_place(
    kitchen: Kitchen, old: str, new: str, message: str, hint: str | None
) -> None:
    kitchen.expect("problem", old, new, message, hint)
