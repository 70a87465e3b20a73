"""The report of a task's planning in the view document."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from kabo.viewer.content.arrays import Arrays
from kabo.viewer.content.document import View

if TYPE_CHECKING:
    from kabo.scene import Scene


def report_view(report: Mapping[str, Any], scene: "Scene | None", arrays: Arrays) -> View | None:
    """The part `report` of a view document, of a report `kabo-task/1`; None: nothing of it is shown yet."""
    return None
