"""BTCS, enriched (ebtcs-n): n packages, one of which holds the bomb, a detector and a toilet in unknown state."""

import kabo

PROBLEM = """\
problem: btcs_n{n}
domain: {home}domain.yaml
objects:
  package: [{packages}]
  bomb: [bomb]
  toilet: [{toilets}]
initial:
  - add(Kf, not defused(bomb))
  - add(Kx, {holds})
goal:
  - K(defused(bomb))
"""


def problem(n: int, home: str = "", toilets: int = 1) -> str:
    """The text of a problem with n packages; nobody knows whether a toilet is clogged.

    Raises:
        kabo.InputError: fewer than two packages, or no toilet.
    """
    if n < 2 or toilets < 1:
        message = f"BTCS takes 2 packages and 1 toilet or more, not {n} and {toilets}"
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, message, None)])
    packages = [f"package_{k}" for k in range(1, n + 1)]
    return PROBLEM.format(
        n=n,
        home=home,
        packages=", ".join(packages),
        toilets=", ".join(f"toilet_{k}" for k in range(1, toilets + 1)),
        holds=", ".join(f"holds({package}, bomb)" for package in packages),
    )
