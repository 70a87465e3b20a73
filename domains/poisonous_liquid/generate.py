"""POISONOUS LIQUID: n bottles, any of which may be poisonous, and as many patches of lawn."""

import kabo

PROBLEM = """\
problem: poisonous_liquid_n{n}
domain: {home}domain.yaml
objects:
  bottle: [{bottles}]
  patch: [{patches}]
initial:
  - forall(patch l) add(Kf, not withered(l))
  - forall(bottle b) add(Kf, not drunk(b))
  - add(Kf, not poisoned)
goal:
  - K(not poisoned)
  - forall(bottle b) Kw(poisonous(b))
  - (exists(bottle b) K(drunk(b))) or (forall(bottle b) K(poisonous(b)))
"""


def problem(n: int, home: str = "") -> str:
    """The text of a problem with n bottles: which are poisonous, and a drink for the thirsty if there is one.

    Raises:
        kabo.InputError: no bottle.
    """
    if n < 1:
        message = f"POISONOUS LIQUID takes 1 bottle or more, not {n}"
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, message, None)])
    return PROBLEM.format(
        n=n,
        home=home,
        bottles=", ".join(f"bottle_{k}" for k in range(1, n + 1)),
        patches=", ".join(f"patch_{k}" for k in range(1, n + 1)),
    )
