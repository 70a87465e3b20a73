"""What is in the way of a failed call: the bodies and robots in the pairs that came too close."""

from kabo.explain.findings import Finding
from kabo.planner.proofs.refused_calls import blocking_pairs


def blocking(finding: Finding) -> list[tuple[str, int]]:
    """The bodies and other robots that blocked attempts, with the number of attempts, the most frequent first."""
    return blocking_pairs(finding.call, ((row.between, row.count) for row in finding.rows if row.between))
