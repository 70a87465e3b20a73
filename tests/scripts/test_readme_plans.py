"""The plans that README files of domains show."""

import pytest

from scripts.readme_plans import ROOT, renewed, shown


def test_there_are_plans_to_look_at():
    assert {path.parent.name for path in shown()} >= {"assembly", "bartender"}


@pytest.mark.parametrize("path", shown(), ids=lambda path: path.parent.name)
def test_a_plan_is_what_the_command_before_it_prints(path):
    assert renewed(path.read_text()) == path.read_text(), (
        f"python -m scripts.readme_plans writes {path.relative_to(ROOT)}"
    )
