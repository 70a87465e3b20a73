"""External calls: how often lazy, eager and adaptive planning ask a procedure, some of whose calls fail.

STACKED n = 20 with a procedure that knows no geometry: whether it fails depends on its arguments and a seed only, for
a share of all arguments; the moves of the goal itself succeed, or there would be no plan. At 50 % samples fail instead,
and may be drawn again with another seed, for fixed failures leave no plan. A call counts as 10 ms.
Promised: lazy planning asks at most as often as the plan is long and five times for each failure; the default costs
at most twice what the better of lazy and eager does.
"""

import tempfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from knowledge_instances import Instance
from table import Table

import kabo
from kabo.plan import plan_statistics

SHARES = (0.0, 0.1, 0.5)
ORDERS = ("lazy", "eager", "adaptive")
RESAMPLED = 0.5  # from this share on it is samples that fail, or there would be no plan
CALL_S = 0.010
PROCEDURE = "restack"


@dataclass
class Counted:
    """A procedure that fails for a share of its arguments, and counts."""

    share: float
    seed: int
    needed: frozenset[tuple[str, ...]] = frozenset()  # what every plan has to do at last, and so never fails
    calls: int = 0
    failures: int = 0

    def __call__(self, *arguments: str) -> bool:
        """Whether it succeeds: the same answer for the same arguments."""
        self.calls += 1
        return self.answer(arguments, self.seed)

    def answer(self, arguments: tuple[str, ...], seed: int) -> bool:
        """The answer that belongs to the arguments and the seed."""
        drawn = zlib.crc32(f"{seed}/{'/'.join(arguments)}".encode()) % 1000
        fails = drawn < 1000 * self.share and arguments[1:] not in self.needed
        self.failures += fails
        return not fails


@dataclass
class Sampled(Counted):
    """A procedure that samples: half of all samples fail, and another seed may succeed."""

    def __call__(self, *arguments: str, seed: int = 0) -> bool:  # type: ignore[override]
        """Whether it succeeds with this seed."""
        self.calls += 1
        return self.answer(arguments, 1000 * self.seed + seed)


def calls(n: int = 20, seeds: int = 3, timeout: float = 120.0) -> Table:
    """One row for each share of failing arguments, seed and order of calls."""
    table = Table(f"External calls, STACKED n = {n}, {1000 * CALL_S:g} ms a call")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "problem.yaml"
        path.write_text(Instance("stacked", "stacked", {"n": n}).text())
        problem = kabo.load_problem(path)
    for share in SHARES:
        for seed in range(seeds if share else 1):
            rows = {order: _row(problem, share, seed, order, timeout) for order in ORDERS}
            costs = [rows[order]["cost s"] for order in ("lazy", "eager") if rows[order]["status"] == "solved"]
            for order, row in rows.items():
                ratio = row["cost s"] / min(costs) if costs and row["status"] == "solved" else None
                table.add(f"{share:.0%} fail, seed {seed}, {order}", **row, **{"to the better": ratio})
    return table


def _row(problem: kabo.Problem, share: float, seed: int, order: str, timeout: float) -> dict[str, Any]:
    claims = [formula.claim for formula in problem.goal]
    needed = frozenset((claim.left.arguments[0].name, claim.right.name) for claim in claims)
    procedure = (Sampled if share >= RESAMPLED else Counted)(share, seed, needed)
    result = kabo.solve(
        problem, search="best", procedures={PROCEDURE: procedure}, geometry_order=order, timeout=timeout
    )
    length = None if result.plan is None else plan_statistics(result.plan).plan_actions
    search = float(result.statistics["symbolic_s"])
    allowed = None if length is None else length + 5 * procedure.failures
    return {
        "status": result.status,
        "calls": procedure.calls,
        "failures": procedure.failures,
        "actions": length,
        "lazy may": allowed if order == "lazy" else None,
        "search s": search,
        "cost s": procedure.calls * CALL_S + search,
    }
