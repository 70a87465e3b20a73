"""An explanation of why there is no plan, in the view document."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from kabo.viewer.content.arrays import Arrays
from kabo.viewer.content.document import View

if TYPE_CHECKING:
    from kabo.scene import Scene


def explanation_view(explanation: Mapping[str, Any], scene: "Scene | None", arrays: Arrays) -> View | None:
    """The part `explanation` of a view document, of the JSON of `kabo explain`; None: nothing is shown yet."""
    return None
