"""SAFES: safes that open for one of n codes each, or that only the right code may be dialled at, which a note tells."""

import kabo

PROBLEM = """\
problem: safes_n{n}{suffix}
domain: {home}domain.yaml
objects:
  safe: [{safes}]
  code: [{codes}]
initial:
  - forall(safe s) add(Kf, not open(s))
{initial}
goal:
  - forall(safe s) K(open(s))
"""


def problem(n: int, home: str = "", safes: int = 1, note: bool = False) -> str:
    """The text of a problem with n codes; with `note`, each safe is guarded and its code may be read.

    Raises:
        kabo.InputError: fewer than two codes, or no safe.
    """
    if n < 2 or safes < 1:
        message = f"SAFES takes 2 codes and 1 safe or more, not {n} and {safes}"
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, message, None)])
    codes = [f"code_{k}" for k in range(1, n + 1)]
    names = [f"safe_{k}" for k in range(1, safes + 1)]
    lines = [f"  - add(Kx, {', '.join(f'combination({safe}) = {code}' for code in codes)})" for safe in names]
    lines += [
        f"  - add(Kf, {'' if note else 'not '}note({safe}), {'' if note else 'not '}guarded({safe}))"
        for safe in names
    ]
    return PROBLEM.format(
        n=n,
        suffix="_with_note" if note else "",
        home=home,
        safes=", ".join(names),
        codes=", ".join(codes),
        initial="\n".join(lines),
    )
