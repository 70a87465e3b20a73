"""The error of a string's line after so many plucks [T Fig. 4.6], placed by Halton's sequence or uniformly."""

import argparse
from itertools import islice

import numpy as np
from exploration_must import must
from exploration_plucks import STRINGS
from guzheng import guzheng
from string_lines import contacts, evenly, off
from table import Table

from kabo.exploration import fit_line

PLUCKS, AHEAD = 90, 30  # of an episode, and those by which a line is judged


def errors(string: str, seed: int, halton: bool, after: list[int]) -> dict[int, float]:
    """The mean distance of the next 30 good contacts from the line that was fitted after so many plucks [mm]."""
    rng = np.random.default_rng([seed, guzheng().strings[string].note])
    share = evenly if halton else lambda _: float(rng.random())
    known = list(islice(contacts(guzheng(), string, rng, share), 2 + max(after) + 2 * AHEAD))
    found = {}
    for plucks in after:
        line = fit_line([each.point for each in known[: 2 + plucks]])
        ahead = [each.point for each in known[2 + plucks :] if not each.astray][:AHEAD]
        found[plucks] = 1e3 * off(line, np.array(ahead))
    return found


def tables(options: argparse.Namespace) -> list[Table]:
    """A row for each number of plucks, and the figures that must be reached."""
    strings = STRINGS[:1] if options.small else STRINGS
    after = [0, 5, 10, 20] if options.small else [0, 2, 5, 10, 15, 20, 30, 50, PLUCKS]
    episodes = [(string, seed) for string in strings for seed in range(options.seeds)]
    curves = Table("Distance of the next 30 contacts from the line [mm]")
    seen: dict[tuple[bool, int], np.ndarray] = {}
    for halton in (True, False):
        each = [errors(string, seed, halton, after) for string, seed in episodes]
        seen.update({(halton, plucks): np.array([found[plucks] for found in each]) for plucks in after})
    for plucks in after:
        even, uniform = seen[True, plucks], seen[False, plucks]
        curves.add(
            f"after {plucks} plucks",
            Halton=float(even.mean()),
            spread=float(even.std()),
            largest=float(even.max()),
            uniform=float(uniform.mean()),
            uniform_spread=float(uniform.std()),
            uniform_largest=float(uniform.max()),
            episodes=len(even),
        )
    judged = Table("Lines: must reach [T Fig. 4.6]")
    must(judged, "mean after 20 plucks [mm]", float(seen[True, 20].mean()), at_most=1.5)
    must(judged, "largest of all episodes after 20 plucks [mm]", float(seen[True, 20].max()), at_most=2.0)
    if not options.small:
        must(judged, "mean after 50 plucks [mm]", float(seen[True, 50].mean()), at_most=1.2)
    return [curves, judged]
