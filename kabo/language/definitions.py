"""What a file of another format defines: domains and problems, before they are put together."""

from collections.abc import Mapping
from typing import Protocol

from kabo.language.findings import Findings
from kabo.language.formulas import Place
from kabo.language.problem import Problem
from kabo.language.source import SourceFile


class Definition(Protocol):
    """A domain or a problem as a file defines it."""

    @property
    def kind(self) -> str:
        """`domain` or `problem`."""

    @property
    def name(self) -> str:
        """Its name in the file."""

    @property
    def source(self) -> SourceFile:
        """The file."""

    @property
    def place(self) -> Place:
        """Where its name stands."""

    @property
    def wanted(self) -> tuple[str, Place] | None:
        """The domain that a problem names, and where."""


class Format(Protocol):
    """How files of one format are read."""

    def definitions(self, source: SourceFile, findings: Findings) -> list[Definition]:
        """All definitions in a file; what is none is reported."""

    def read(
        self, domain: Definition, problem: Definition | None, findings: Findings, files: Mapping[str, str]
    ) -> Problem | None:
        """The problem of two definitions; None for a domain alone, which is only checked."""
