"""BIMANUAL ASSEMBLY of n gearboxes, two bearings, a pipe and a tree each [K Tables 6.5, 6.6].

The table has room for the parts of two; more make a problem without a scene, for the search alone.
"""

import kabo

KINDS = ("bearing", "bearing", "pipe", "tree")
PLACES = (  # on the table [m], in the order of the parts
    (0.12, 0.32), (0.00, -0.40), (-0.02, 0.50), (0.02, 0.06),
    (-0.06, 0.30), (-0.12, -0.30), (0.10, 0.62), (-0.18, 0.06),
)  # fmt: skip

PROBLEM = """\
problem: assembly_{name}
domain: {home}domain.yaml
{scene}objects:
  robot: [robot_1, robot_2]
  object: [{objects}]
{bodies}initial:
  - add(Kf, {kinds})
  - forall(robot r) add(Kf, hand_empty(r))
  - forall(object o) add(Kf, not contained(o), not grasped(o))
{goal}
"""
ONE = "goal: exists(object o) (K(is_a_gearbox(o)) and K(not grasped(o)))"


def problem(n: int, home: str = "") -> str:
    """The text of a problem file with parts for n gearboxes; `home` leads from its folder to this one.

    Raises:
        kabo.InputError: no gearbox.
    """
    if n < 1:
        text = f"ASSEMBLY makes 1 gearbox or more, not {n}"
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, text, None)])
    parts = [(f"o{k + 1}", KINDS[k % len(KINDS)]) for k in range(len(KINDS) * n)]
    pipes = [name for name, kind in parts if kind == "pipe"]
    stand = len(parts) <= len(PLACES)
    lines = [
        f"  {name}: {{model: {kind}, pose: {{position: [{x:.2f}, {y:.2f}, 0]}}}}"
        for (name, kind), (x, y) in zip(parts, PLACES, strict=False)
    ]
    goals = [f"  - K(is_a_gearbox({name})) and K(not grasped({name}))" for name in pipes]
    return PROBLEM.format(
        name="gearbox" if n == 1 else f"{n}_gearboxes",
        home=home,
        scene=f"scene: {home}scene.yaml\n" if stand else "",
        objects=", ".join(name for name, _ in parts),
        bodies="\n".join(["bodies:", *lines, ""]) if stand else "",
        kinds=", ".join(f"is_a_{kind}({name})" for name, kind in parts),
        goal=ONE if n == 1 else "\n".join(["goal:", *goals]),
    )
