"""CANADIAN TRAVELLER (ctp-n): n stages, each with two roads to the next town, exactly one of them passable."""

import kabo

PROBLEM = """\
problem: canadian_traveller_n{n}
domain: {home}domain.yaml
objects:
  town: [{towns}]
  road: [{roads}]
initial:
  - add(Kf, position = town_0)
{stages}
goal:
  - K(position = town_{n})
"""


def problem(n: int, home: str = "") -> str:
    """The text of a problem with n stages; the roads from town k are a_k and b_k.

    Raises:
        kabo.InputError: no stage.
    """
    if n < 1:
        message = f"CANADIAN TRAVELLER takes 1 stage or more, not {n}"
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, message, None)])
    stages = [
        f"  - add(Kf, ends_at({road}, town_{k}), ends_at({road}, town_{k + 1}))"
        for k in range(n)
        for road in (f"a_{k}", f"b_{k}")
    ]
    stages += [f"  - add(Kx, passable(a_{k}), passable(b_{k}))" for k in range(n)]
    return PROBLEM.format(
        n=n,
        home=home,
        towns=", ".join(f"town_{k}" for k in range(n + 1)),
        roads=", ".join(f"a_{k}, b_{k}" for k in range(n)),
        stages="\n".join(stages),
    )
