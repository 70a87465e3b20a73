"""`python -m tests.fuzz`: fuzzed files of every format for some minutes, or so many of them; finds are kept.

python -m tests.fuzz --minutes 60            # an hour by hand
python -m tests.fuzz --count 300000          # so many files over all formats, from number 0 on
python -m tests.fuzz --only opened mesh --first 5000 --count 1000
"""

import argparse
import sys
import time
from pathlib import Path

from tests.fuzz.formats import FORMATS
from tests.fuzz.running import counts, run_apart

STEP = 20_000  # files a round


def main() -> int:
    """Runs rounds until the time or the count is up; 1 if anything was found."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--minutes", type=float, default=None)
    parser.add_argument("--count", type=int, default=None)
    parser.add_argument("--first", type=int, default=0, help="the number of the first case of each format")
    parser.add_argument("--only", nargs="+", default=list(FORMATS), choices=list(FORMATS))
    parser.add_argument("--kept", type=Path, default=Path("finds"), help="where files that were found go")
    options = parser.parse_args()
    began, done, found = time.monotonic(), 0, 0
    following = dict.fromkeys(options.only, options.first)
    left = options.count if options.count is not None else STEP * 10**6 if options.minutes else STEP
    spent: dict[str, float] = dict.fromkeys(options.only, 0.0)
    while left > 0 and (options.minutes is None or time.monotonic() - began < 60 * options.minutes):
        step = counts(min(left, STEP), options.only)
        for name, count in step.items():
            before = time.monotonic()
            finds = run_apart(name, range(following[name], following[name] + count), kept=options.kept)
            following[name] += count
            spent[name] += time.monotonic() - before
            for find in finds:
                print(find, flush=True)
            found, done = found + len(finds), done + count
        left -= STEP
        print(f"{done} files, {found} finds, {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)
    print({name: round(seconds, 1) for name, seconds in spent.items()}, file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
