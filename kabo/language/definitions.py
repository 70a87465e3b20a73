"""Domains and problems as PDDL and PKS files define them, before a problem and its domain are joined."""

from collections.abc import Mapping
from typing import Protocol

from kabo.language.findings import Findings
from kabo.language.formulas import Place
from kabo.language.problem import Problem
from kabo.language.source import SourceFile


class Definition(Protocol):
    """A domain or a problem as it is defined in a file."""

    @property
    def kind(self) -> str:
        """The kind of the definition: `domain` or `problem`."""

    @property
    def name(self) -> str:
        """The name of the domain or problem in the file."""

    @property
    def source(self) -> SourceFile:
        """The file that contains the definition."""

    @property
    def place(self) -> Place:
        """The place of the definition's name in the file."""

    @property
    def wanted(self) -> tuple[str, Place] | None:
        """The domain that a problem names, and the place of that name; None for a domain."""


class Format(Protocol):
    """A reader of one file format."""

    def definitions(self, source: SourceFile, findings: Findings) -> list[Definition]:
        """All definitions in a file; anything else in it is reported."""

    def read(
        self, domain: Definition, problem: Definition | None, findings: Findings, files: Mapping[str, str]
    ) -> Problem | None:
        """The problem made from both definitions; None for a domain alone, which is only checked."""
