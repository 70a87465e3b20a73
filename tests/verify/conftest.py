"""The small world of `counter.py`, written once."""

import pytest

from tests.verify.counter import Counter, load


@pytest.fixture(scope="session")
def counter(tmp_path_factory: pytest.TempPathFactory) -> Counter:
    """The problem and the right plan."""
    return load(tmp_path_factory.mktemp("counter"))
