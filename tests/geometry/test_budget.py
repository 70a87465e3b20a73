"""How epsilon is divided."""

import numpy as np
import pytest

from kabo.geometry.budget import Budget
from kabo.options import LARGEST_EPSILON, SMALLEST_EPSILON


@pytest.mark.parametrize("epsilon", [SMALLEST_EPSILON, 1e-4, 2e-3, 5e-3, 0.02, LARGEST_EPSILON])
def test_the_parts_sum_up_to_epsilon(epsilon):
    budget = Budget.share(epsilon)
    assert budget.epsilon == pytest.approx(epsilon, rel=1e-12)
    assert min(budget.geometry, budget.sweep, budget.clearance, budget.numeric) > 0
    assert budget.geometry == pytest.approx(0.4 * epsilon)


@pytest.mark.parametrize("epsilon", [k / 1000 for k in range(1, 301)])
def test_the_epsilon_of_its_shares_is_the_same_float(epsilon):
    """The verifier compares the epsilon of a certificate with that of the plan, and 0.005 is no sum of its shares."""
    assert Budget.share(epsilon).epsilon == epsilon


@pytest.mark.parametrize("epsilon", [0.0, -0.01, np.nan, np.inf, SMALLEST_EPSILON / 2, LARGEST_EPSILON * 1.01])
def test_an_epsilon_that_makes_no_sense_is_refused(epsilon):
    with pytest.raises(ValueError, match="epsilon must lie between"):
        Budget.share(epsilon)


def test_a_free_gap_exceeds_the_clearance_by_what_rounding_may_take():
    budget = Budget.share(0.01)
    assert budget.clearance < budget.margin < budget.clearance + budget.numeric
