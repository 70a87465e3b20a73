"""Contacts that a task permits for good: its plan claims them where something may grant them, and nowhere else."""

from pathlib import Path

import pytest

import kabo

EXAMPLE = Path(__file__).parents[3] / "examples" / "pick_and_place"
TASK_TEXT = (EXAMPLE / "task.yaml").read_text()
FORBID_AT_END = TASK_TEXT[
    TASK_TEXT.index("      - name: forbid contact\n") : TASK_TEXT.index("      - {name: retreat")
]
FORBID_SUPPORT = next(
    line for line in TASK_TEXT.splitlines(keepends=True) if "name: forbid contact of object" in line
)
HOLDING = TASK_TEXT[TASK_TEXT.index("  - {name: move to place") : TASK_TEXT.index("  - {name: go home")]


@pytest.mark.parametrize("left_out", [[FORBID_AT_END], [FORBID_SUPPORT, HOLDING]])
def test_a_contact_that_is_never_forbidden_again_does_not_spoil_a_motion_that_needs_none(tmp_path, left_out):
    """The plan claims contacts only where something may grant them; elsewhere the two are proven apart."""
    text = TASK_TEXT
    for each in left_out:
        assert text.count(each) == 1
        text = text.replace(each, "")
    (tmp_path / "task.yaml").write_text(text)
    report = kabo.plan_task(tmp_path / "task.yaml", EXAMPLE / "scene.yaml", max_solutions=1)
    plan = kabo.task_plan(report)
    judged = kabo.verify(report.scene, plan)
    assert judged.ok, judged
    assert not plan.nodes["n0"].motion[-1].allowed_contacts or left_out[0] is FORBID_SUPPORT


def test_a_contact_that_is_permitted_and_made_where_nothing_grants_it_is_refused(tmp_path):
    """The arm comes back to where it let the object go, with its fingers shut."""
    back = """  - {name: shut, stage: MoveTo, goal: {finger_joint: 0.01}}
  - {name: back, stage: MoveRelative, direction: {along: tool.approach, distance: 0.12}}
"""
    text = TASK_TEXT.replace(FORBID_AT_END, "").replace("distance: [0.12, 0.25]", "distance: 0.12")
    text = text[: text.index("  - {name: go home")] + back
    (tmp_path / "task.yaml").write_text(text)
    report = kabo.plan_task(tmp_path / "task.yaml", EXAMPLE / "scene.yaml", max_solutions=1)
    judged = kabo.verify(report.scene, kabo.task_plan(report))
    assert not judged.ok and "object" in str(judged)
