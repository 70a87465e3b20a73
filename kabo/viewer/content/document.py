"""The view document: everything that a page shows, as plain data, with its arrays beside it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from kabo.viewer.content.arrays import Arrays

FORMAT = "kabo-view/1"

Given = Literal["scene", "problem", "task", "plan", "report", "explanation", "run"]
View = Mapping[str, Any]  # a part of the document, ready for JSON


@dataclass(frozen=True)
class ViewDocument:
    """What a page shows; parts that were not given are None, and references in all parts are into `arrays`."""

    title: str
    given: Given
    scene: View | None = None
    findings: Sequence[View] = ()
    plan: View | None = None
    report: View | None = None
    explanation: View | None = None
    live: View | None = None
    run: View | None = None
    arrays: Arrays = field(default_factory=Arrays)

    def to_json(self) -> dict[str, Any]:
        """The document, with the table of its arrays."""
        return {
            "format": FORMAT,
            "title": self.title,
            "given": self.given,
            "scene": self.scene,
            "findings": list(self.findings),
            "plan": self.plan,
            "report": self.report,
            "explanation": self.explanation,
            "live": self.live,
            "run": self.run,
            "arrays": self.arrays.table,
        }
