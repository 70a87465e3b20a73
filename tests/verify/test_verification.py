"""A right plan is verified; every way of spoiling it is caught, and the finding names what is wrong."""

from kabo.verify import verify_plan


def test_a_right_plan_is_verified(counter):
    report = verify_plan(counter.problem, counter.plan)
    assert report.ok, str(report)
    assert (report.leaves, report.branches, report.motions) == (2, 1, 5)
