"""How do plans do that are carried out? Sections, each in a module of its own.

    python benchmarks/execution.py [worlds robots speed late repair ...] [--problems FILE ...] [--output FILE]

`worlds`: the mean number of actions in worlds that are drawn, beside the mean over all worlds that `kabo verify` reports.
`robots`: those of example-robot-data in physics, at rest and along random motions. `speed`, `late` and `repair`: how fast
physics and answers are, and what becomes of late or weak robots.
"""

import argparse
from collections.abc import Callable
from pathlib import Path

from execution_robots import robots
from execution_speed import late, repair, speed
from execution_worlds import worlds
from table import Table, finish

SECTIONS: dict[str, Callable[[argparse.Namespace], Table | list[Table]]] = {
    "worlds": worlds,
    "robots": robots,
    "speed": speed,
    "late": late,
    "repair": repair,
}


def main() -> None:
    """Runs the sections that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", nargs="*", default=list(SECTIONS), choices=list(SECTIONS), help="default: all")
    parser.add_argument(
        "--problems", nargs="*", type=Path, help="problem files, from the repository on (default: of each section)"
    )
    parser.add_argument("--rounds", type=int, default=3, help="of `speed`, of which the best counts")
    parser.add_argument("--worlds", type=int, default=10_000, help="that are drawn for each problem")
    parser.add_argument(
        "--robots", nargs="*", default=[], metavar="NAME", help="of benchmarks/robots.py (default: all)"
    )
    parser.add_argument("--seed", type=int, default=0, help="of random motions")
    parser.add_argument("--output", type=Path, help="JSON")
    options = parser.parse_args()
    tables: list[Table] = []
    for name in options.sections:
        made = SECTIONS[name](options)
        tables += made if isinstance(made, list) else [made]
    finish(tables, options.output, worlds=options.worlds, robots=options.robots, seed=options.seed)


if __name__ == "__main__":
    main()
