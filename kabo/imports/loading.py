"""From paths of any format to a Problem: told by their endings, with the files that belong together.

YAML files go to the language room; PDDL and PKS files are read here.
"""

import os
from collections.abc import Iterable, Sequence
from pathlib import Path

from kabo.errors import Diagnostic, InputError
from kabo.imports.forms import read_forms
from kabo.imports.pddl_problem import read_pddl
from kabo.imports.pddl_sections import Definition, definitions_of
from kabo.language import loading as yaml
from kabo.language.findings import Findings
from kabo.language.formulas import Place
from kabo.language.paths import OUTSIDE, beside, lies_within, near_file
from kabo.language.problem import Problem
from kabo.language.source import SourceFile, UnreadableError, read_source

MAX_BYTES = 8_000_000
PDDL = (".pddl",)
PKS = (".xml", ".pks")


def is_imported(path: str | Path) -> bool:
    """Whether the file is of another format than kabo's own."""
    return Path(path).suffix.lower() in PDDL + PKS


def load_problem(path: str | Path, other: str | Path | None = None, *, within: Path | None = None) -> Problem:
    """The problem of one or two files in any format that kabo reads; opens no mesh and no URDF.

    Args:
        path: the problem file: YAML, PDDL (`.pddl`) or PKS (`.xml`, `.pks`).
        other: the domain file that belongs to it, for PDDL and PKS; in which order the two stand does not matter.
            Without it the domain is the file's own, or that of `domain.pddl` or `<its name>.pddl` beside it.
        within: if given, no file outside of this folder is opened (links are followed first).

    Raises:
        InputError: with every diagnostic of all files that belong to the problem.
    """
    named = [os.fspath(each) for each in (path, other) if each is not None]
    if not any(map(is_imported, named)):
        if len(named) == 1:
            return yaml.load_problem(path, within=within)
        message = "one file is enough: a problem in YAML names its domain itself"
        raise InputError([Diagnostic(named[1], 1, 1, message, f"leave {named[0]} or {named[1]} out")])
    reading = Reading(within)
    problem = reading.problem(named)
    if problem is None or reading.findings.errors:
        raise InputError(reading.findings.diagnostics)
    return problem


def check_files(paths: Iterable[str | Path]) -> list[Diagnostic]:
    """All diagnostics of files in any format, and of the files that problems name, sorted by place."""
    named = [os.fspath(path) for path in paths]
    found = dict.fromkeys(yaml.check_files([name for name in named if not is_imported(name)]))
    for endings in (PDDL, PKS):
        reading = Reading(None)
        reading.check([name for name in named if Path(name).suffix.lower() in endings])
        found.update(dict.fromkeys(reading.findings.diagnostics))
    return sorted(found, key=lambda d: (d.file, d.line, d.column, d.message))


class Reading:
    """One reading of files that belong together."""

    def __init__(self, within: Path | None) -> None:
        self.findings = Findings()
        self.digests: dict[str, str] = {}
        self._within = within

    def problem(self, named: Sequence[str]) -> Problem | None:
        """The only problem of the files, with its domain."""
        endings = {Path(name).suffix.lower() in PDDL for name in named}
        if len(endings) > 1 or not all(map(is_imported, named)):
            self.findings.add(Place(named[-1], 1, 1), "the two files are of different formats")
            return None
        definitions = [each for name in named for each in self._definitions(name)]
        if self.findings.errors:
            return None
        problems = [each for each in definitions if each.kind == "problem"]
        if len(problems) != 1:
            self._report_number(named, definitions, problems)
            return None
        domain = self._domain(problems[0], definitions, explicit=len(named) > 1)
        return None if domain is None else self._read(domain, problems[0])

    def check(self, named: Sequence[str]) -> None:
        """Checks every definition of the files; a problem with its domain, a domain alone if no problem has it."""
        definitions = [each for name in named for each in self._definitions(name)]
        used = []
        for each in definitions:
            if each.kind == "problem":
                domain = self._domain(each, definitions, explicit=False)
                if domain is not None:
                    self._read(domain, each)
                    used.append(domain)
        for each in definitions:
            if each.kind == "domain" and each not in used:
                self._read(each, None)

    def _read(self, domain: Definition, problem: Definition | None) -> Problem | None:
        folder = os.path.dirname((problem or domain).document.source.name) or "."
        sources = [each.document.source for each in (problem, domain) if each is not None]
        files = {os.path.relpath(source.name, folder).replace(os.sep, "/"): source.digest for source in sources}
        return read_pddl(domain, problem, self.findings, files)

    # ------------------------------------------------------------------------------------------------------- files
    def _definitions(self, name: str) -> list[Definition]:
        """The domains and problems in a file."""
        source = self._source(name)
        document = None if source is None else read_forms(source, self.findings)
        return [] if document is None else definitions_of(document)

    def _source(self, name: str) -> SourceFile | None:
        try:
            if not lies_within(Path(name), self._within):
                raise UnreadableError(OUTSIDE)
            source = read_source(Path(name), name, MAX_BYTES)
        except UnreadableError as error:
            place = Place(name, 1, 1)
            if error.offset is not None:
                before = error.text[: error.offset]
                place = Place(name, before.count("\n") + 1, error.offset - before.rfind("\n"))
            hint = error.hint or near_file(self.findings, Path(name), self._within)
            self.findings.add(place, error.message, hint)
            return None
        self.digests[name] = source.digest
        return source

    def _report_number(
        self, named: Sequence[str], definitions: list[Definition], problems: list[Definition]
    ) -> None:
        if problems:
            again = problems[1]
            message = f'a second problem, "{again.name}", stands here: only one can be solved at a time'
            again.document.report(again.named_at, message)
        elif definitions:
            domain = definitions[-1]
            domain.document.report(domain.named_at, "a problem is needed here, this is a domain")
        else:
            self.findings.add(Place(named[0], 1, 1), 'there is no problem here, expected "(define (problem …"')

    def _domain(self, problem: Definition, definitions: list[Definition], *, explicit: bool) -> Definition | None:
        """The domain that a problem names: among what was read, else beside its file."""
        section = problem.first(":domain")
        word = None if section is None or len(section.items) != 2 else section.items[1]
        wanted = getattr(word, "text", None)
        if wanted is None or word is None:
            problem.document.report(section or problem.named_at, 'a problem needs "(:domain name)"')
            return None
        domains = [each for each in definitions if each.kind == "domain"]
        for each in domains:
            if each.name == wanted:
                return each
        if domains and (explicit or len(domains) == 1):
            message = f'the problem is for the domain "{wanted}", used is "{domains[0].name}"'
            problem.document.report(word, message, warning=True)
            return domains[0]
        return self._beside(problem, wanted, word)

    def _beside(self, problem: Definition, wanted: str, word: object) -> Definition | None:
        folder = os.path.dirname(problem.document.source.name)
        others = []
        for candidate in dict.fromkeys(("domain.pddl", f"{wanted}.pddl")):
            if "/" in candidate or "\\" in candidate or "\0" in candidate:
                continue
            name = beside(folder, candidate)
            if name == os.path.normpath(problem.document.source.name) or not self._exists(name):
                continue
            found = [each for each in self._definitions(name) if each.kind == "domain"]
            for each in found:
                if each.name == wanted:
                    return each
            others += found
        hint = f"name its file as well, or put it beside this one as domain.pddl or {wanted}.pddl"
        if others:
            hint = f'domain.pddl defines "{others[0].name}"; ' + hint
        problem.document.report(word, f'there is no domain "{wanted}" here', hint)  # type: ignore[arg-type]
        return None

    def _exists(self, name: str) -> bool:
        return lies_within(Path(name), self._within) and os.path.isfile(name)
