"""BOMB IN THE TOILET: n packages, one of them armed, and nobody can tell which."""

import kabo

PROBLEM = """\
problem: bomb_in_the_toilet_n{n}
domain: {home}domain.yaml
objects:
  package: [{packages}]
  toilet: [{toilets}]
initial:
  - add(Kx, {armed})
  - forall(toilet t) add(Kf, not clogged(t))
goal:
  - forall(package p) K(not armed(p))
"""


def problem(n: int, home: str = "", toilets: int = 1) -> str:
    """The text of a problem with n packages, whose shortest plan has 2 n - `toilets` actions.

    Raises:
        kabo.InputError: fewer packages than toilets, or no toilet.
    """
    if not 1 <= toilets <= n:
        message = f"BOMB IN THE TOILET takes 1 toilet or more and as many packages, not {toilets} and {n}"
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, message, None)])
    packages = [f"package_{k}" for k in range(1, n + 1)]
    return PROBLEM.format(
        n=n,
        home=home,
        packages=", ".join(packages),
        toilets=", ".join(f"toilet_{k}" for k in range(1, toilets + 1)),
        armed=", ".join(f"armed({package})" for package in packages),
    )
