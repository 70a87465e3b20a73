"""STACKED n OBJECTS [K 6.2.2]: o2 … on stand on one stack, o1 beside them; o1 has to go under all of them."""

import kabo

PAD = 0.01  # its height [m]
HEIGHTS = {"block": 0.04, "tile": 0.02}  # of the scene's models [m]
CUBES = 10  # blocks of a tower that the arm reaches; higher ones are of flat blocks

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
"""


def problem(n: int, home: str = "") -> str:
    """The text of a problem with n blocks, whose shortest plan has 2 n - 1 actions; `home` leads to this folder.

    Raises:
        kabo.InputError: fewer than two blocks.
    """
    if n < 2:
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, f"STACKED takes 2 blocks or more, not {n}", None)])
    model = "block" if n <= CUBES else "tile"
    start = [("o2", "stack_1"), *((f"o{k}", f"o{k - 1}") for k in range(3, n + 1)), ("o1", "stack_2")]
    goal = [("o1", "stack_1"), *((f"o{k}", f"o{k - 1}") for k in range(2, n + 1))]
    return PROBLEM.format(
        n=n,
        home=home,
        names=", ".join(f"o{k}" for k in range(1, n + 1)),
        bodies="\n".join(_body(block, model, below) for block, below in start),
        below=", ".join(f"one_below({block}) = {below}" for block, below in start),
        goal="\n".join(f"  - K(one_below({block}) = {below})" for block, below in goal),
    )


def _body(block: str, model: str, below: str) -> str:
    height = HEIGHTS[model] if below.startswith("o") else PAD / 2.0 + HEIGHTS[model] / 2.0
    return f"  {block}: {{model: {model}, pose: {{frame: {below}, position: [0, 0, {height:.3g}]}}}}"
