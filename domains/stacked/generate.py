"""STACKED n OBJECTS [K 6.2.2]: o2 … on stand on one stack, o1 beside them; o1 has to go under all of them."""

import kabo

PAD, BLOCK = 0.01, 0.04  # heights [m]

PROBLEM = """\
problem: stacked_n{n}
domain: {home}domain.yaml
scene: {home}scene.yaml
objects:
  robot: [mobile]
  block: [{names}]
  stack: [stack_1, stack_2, stack_3]
bodies:
{bodies}
initial:
  - add(Kf, highest(o{n}), highest(o1), highest(stack_3))
  - add(Kf, {below})
goal:
{goal}
options: {{search: breadth-first}}
"""


def problem(n: int, home: str = "") -> str:
    """The text of a problem with n blocks, whose shortest plan has 2 n - 1 actions; `home` leads to this folder.

    Raises:
        kabo.InputError: fewer than two blocks.
    """
    if n < 2:
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, f"STACKED takes 2 blocks or more, not {n}", None)])
    start = [("o2", "stack_1"), *((f"o{k}", f"o{k - 1}") for k in range(3, n + 1)), ("o1", "stack_2")]
    goal = [("o1", "stack_1"), *((f"o{k}", f"o{k - 1}") for k in range(2, n + 1))]
    return PROBLEM.format(
        n=n,
        home=home,
        names=", ".join(f"o{k}" for k in range(1, n + 1)),
        bodies="\n".join(_body(block, below) for block, below in start),
        below=", ".join(f"one_below({block}) = {below}" for block, below in start),
        goal="\n".join(f"  - K(one_below({block}) = {below})" for block, below in goal),
    )


def _body(block: str, below: str) -> str:
    height = BLOCK if below.startswith("o") else PAD / 2.0 + BLOCK / 2.0
    return f"  {block}: {{model: block, pose: {{frame: {below}, position: [0, 0, {height:.3g}]}}}}"
