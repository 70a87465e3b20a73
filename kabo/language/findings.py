"""Findings: all errors and warnings of one reading, collected so that they are reported at once."""

import os
from collections.abc import Collection, Mapping
from pathlib import Path

from kabo.errors import Diagnostic, did_you_mean
from kabo.language.formulas import Place
from kabo.language.source import SourceFile, UnreadableError, lies_within

_MOST_FINDINGS = 1000
_MOST_SUGGESTIONS = 200  # looking for near names costs up to the product of both lists
_MOST_NAMES = 500
_FEW = 16


class Findings:
    """The errors and warnings found while one set of files is read, without duplicates."""

    def __init__(self) -> None:
        self._found: dict[tuple[str, int, int, str], Diagnostic] = {}
        self._sources: dict[str, SourceFile] = {}
        self._suggestions = 0
        self._last: Place | None = None  # of the finding that ends the list

    def know(self, source: SourceFile) -> None:
        """Registers a source, so that findings in it can quote its lines."""
        self._sources[source.name] = source

    def add(self, place: Place, message: str, hint: str | None = None, *, warning: bool = False) -> None:
        """Records one finding at `place`."""
        if len(self._found) >= _MOST_FINDINGS:
            message, hint = f"there are more than {_MOST_FINDINGS} findings; the rest is not shown", None
            place = Place(place.file, 1, 1) if self._last is None else self._last
            self._last = place
        source = self._sources.get(place.file)
        line = source.shown_line(place.line) if source is not None else None
        self._found.setdefault(
            (place.file, place.line, place.column, message),
            Diagnostic(
                place.file, place.line, place.column, message, hint, place.length,
                "warning" if warning else "error", line,
            ),
        )  # fmt: skip

    def include(self, finding: Diagnostic) -> None:
        """Records a finding that was made elsewhere, with its own line."""
        if len(self._found) < _MOST_FINDINGS:
            self._found.setdefault((finding.file, finding.line, finding.column, finding.message), finding)

    def near(
        self,
        word: str,
        known: Collection[str],
        declared: Mapping[str, tuple[str, Place | None]] | None = None,
        *,
        all_if_few: bool = True,
    ) -> str | None:
        """The remedy `did you mean "…"?`, with the declaration of the proposed word; None if none is similar.

        Args:
            word: the unknown word in the file.
            known: the words that could have been meant.
            declared: for some of the words in `known`, the signature as text and the place of the declaration.
            all_if_few: whether all known words are listed if none is similar and there are few of them.
        """
        self._suggestions += 1
        if not self.may_suggest or len(known) > _MOST_NAMES or len(word) > 80:
            return None
        remedy = did_you_mean(word, known)
        if remedy is None:
            return f"there are {', '.join(known)}" if 0 < len(known) <= _FEW and all_if_few else None
        if declared is None:
            return remedy
        signature, place = declared.get(remedy.split('"')[1], ("", None))
        return remedy if place is None else f"{remedy} {signature} is declared at {spell_place(place)}"

    def near_file(self, path: Path, within: Path | None = None) -> str | None:
        """The remedy `did you mean "…"?` for a missing file, from the names in its folder; else None."""
        try:
            if not lies_within(path.parent, within) or path.exists():
                return None
            beside_it = sorted(os.listdir(path.parent))
        except (OSError, ValueError):
            return None
        return self.near(path.name, beside_it, all_if_few=False)

    def add_unreadable(self, name: str, error: UnreadableError, within: Path | None = None) -> None:
        """Records that the file `name` cannot be read; the remedy may be a similar name in the same folder."""
        self.add(error.place(name), error.message, error.hint or self.near_file(Path(name), within))

    @property
    def may_suggest(self) -> bool:
        """Whether to search for similar names: false after many suggestions, since each search takes time."""
        return self._suggestions <= _MOST_SUGGESTIONS

    @property
    def diagnostics(self) -> list[Diagnostic]:
        """All findings, sorted by file and place."""
        return sorted(self._found.values(), key=lambda d: (d.file, d.line, d.column, d.message))

    @property
    def errors(self) -> list[Diagnostic]:
        """The findings that are errors, without the warnings."""
        return [each for each in self.diagnostics if each.severity == "error"]


def spell_place(place: Place) -> str:
    """A place as text, such as `domain.yaml:12:3`, with the file's name but not its folder."""
    return f"{place.file.replace(chr(92), '/').rsplit('/', 1)[-1]}:{place.line}:{place.column}"
