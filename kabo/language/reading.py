"""Reads a Problem from paths in any format, which the file's ending determines; domains are found beside problems.

YAML files are read by kabo.language.yaml; in this module, domains and problems of PDDL and PKS are put together.
"""

import os
from collections.abc import Iterable, Sequence
from pathlib import Path

from kabo.errors import Diagnostic, InputError
from kabo.given import require_path
from kabo.language.definitions import Definition, Format
from kabo.language.findings import Findings
from kabo.language.formulas import Place
from kabo.language.problem import Problem
from kabo.language.source import SourceFile, UnreadableError, beside, lies_within, read_source

MAX_BYTES = 8_000_000
PDDL = (".pddl",)
PKS = (".xml", ".pks")


def is_imported(path: str | Path) -> bool:
    """Whether the file is a PDDL or PKS file, judged by its ending."""
    return Path(path).suffix.lower() in PDDL + PKS


def load_problem(path: str | Path, other: str | Path | None = None, *, within: Path | None = None) -> Problem:
    """The problem of one or two files in any format that kabo reads; opens no mesh and no URDF.

    Args:
        path: the problem file: YAML, PDDL (`.pddl`) or PKS (`.xml`, `.pks`).
        other: the domain file of the problem, for PDDL and PKS; `path` and `other` may be exchanged. If it is
            None, the domain is looked for in the problem file, and in `domain.pddl` or `<domain's name>.pddl` in
            its folder.
        within: if given, no file outside of this folder is opened (links are followed first).

    Raises:
        ArgumentError: an argument is no path.
        InputError: with every diagnostic of all files that belong to the problem.

    Example:
        >>> kabo.load_problem("domains/grid/n3.yaml")
        <Problem grid_n3_2: 13 objects, 5 actions, 1 goal>
    """
    within = None if within is None else require_path("within", within)
    others = () if other is None else (require_path("other", other),)
    named = [os.fspath(each) for each in (require_path("path", path), *others)]
    own = [name for name in named if not is_imported(name)]
    if own and len(named) == 1:
        from kabo.language.yaml.loading import load_problem as load_yaml

        return load_yaml(path, within=within)
    if own:
        message = "one file is enough: a problem in YAML names its domain itself"
        raise InputError([Diagnostic(own[-1], 1, 1, message, f'write only one of "{named[0]}" and "{named[1]}"')])
    reading = Reading(within)
    problem = reading.problem(named)
    if problem is None or reading.findings.errors:
        raise InputError(reading.findings.diagnostics)
    return problem


def check_files(paths: Iterable[str | Path]) -> list[Diagnostic]:
    """All diagnostics of files in any format, and of the files that problems name, sorted by place."""
    from kabo.language.yaml.loading import check_files as check_yaml

    named = [os.fspath(path) for path in paths]
    found = dict.fromkeys(check_yaml([name for name in named if not is_imported(name)]))
    for endings in (PDDL, PKS):
        reading = Reading(None)
        reading.check([name for name in named if Path(name).suffix.lower() in endings])
        found.update(dict.fromkeys(reading.findings.diagnostics))
    return sorted(found, key=lambda d: (d.file, d.line, d.column, d.message))


class Reading:
    """Reads PDDL or PKS files that belong together, and collects the errors and warnings about them."""

    def __init__(self, within: Path | None) -> None:
        self.findings = Findings()
        self._within = within

    def problem(self, named: Sequence[str]) -> Problem | None:
        """The only problem in the files, with its domain; None after an error, as for several problems."""
        if len({type(_format_of(name)) for name in named}) > 1:
            self.findings.add(Place(named[-1], 1, 1), "the two files are of different formats")
            return None
        definitions = [each for name in named for each in self._definitions(name)]
        if self.findings.errors:
            return None
        problems = [each for each in definitions if each.kind == "problem"]
        if len(problems) != 1:
            self._report_number(named, definitions, problems)
            return None
        domain = self._domain(problems[0], definitions)
        return None if domain is None else self._read(domain, problems[0])

    def check(self, named: Sequence[str]) -> None:
        """Checks every problem in the files together with its domain, and every domain that no problem uses."""
        definitions = [each for name in named for each in self._definitions(name)]
        used: list[Definition] = []
        for each in definitions:
            if each.kind == "problem":
                domain = self._domain(each, definitions)
                if domain is not None:
                    self._read(domain, each)
                    used.append(domain)
        for each in definitions:
            if each.kind == "domain" and each not in used:
                self._read(each, None)

    def _read(self, domain: Definition, problem: Definition | None) -> Problem | None:
        folder = os.path.dirname((problem or domain).source.name) or "."
        sources = [each.source for each in (problem, domain) if each is not None]
        files = {os.path.relpath(each.name, folder).replace(os.sep, "/"): each.digest for each in sources}
        return _format_of(domain.source.name).read(domain, problem, self.findings, files)

    def _definitions(self, name: str) -> list[Definition]:
        """The domains and problems in a file."""
        source = self._source(name)
        return [] if source is None else _format_of(name).definitions(source, self.findings)

    def _source(self, name: str) -> SourceFile | None:
        try:
            return read_source(Path(name), name, MAX_BYTES, within=self._within)
        except UnreadableError as error:
            self.findings.add_unreadable(name, error, self._within)
            return None

    def _report_number(
        self, named: Sequence[str], definitions: list[Definition], problems: list[Definition]
    ) -> None:
        if problems:
            again = problems[1]
            message = f'a second problem, "{again.name}", stands here: only one can be solved at a time'
            self.findings.add(again.place, message)
        elif definitions:
            self.findings.add(definitions[-1].place, "a problem is needed here, this is a domain")
        else:
            self.findings.add(Place(named[0], 1, 1), "there is no problem in this file")

    # --------------------------------------------------------------------------------------------------- the domain
    def _domain(self, problem: Definition, definitions: list[Definition]) -> Definition | None:
        """The domain that a problem names: among what was read, else beside its file."""
        if problem.wanted is None:
            self.findings.add(problem.place, "a problem must name its domain")
            return None
        wanted, place = problem.wanted
        domains = [each for each in definitions if each.kind == "domain"]
        for each in domains:
            if each.name == wanted:
                return each
        if len(domains) == 1 and (not wanted or domains[0].source != problem.source):
            if wanted:
                message = f'the problem is for the domain "{wanted}", used is "{domains[0].name}"'
                self.findings.add(place, message, warning=True)
            return domains[0]
        return self._beside(problem, wanted, place)

    def _beside(self, problem: Definition, wanted: str, place: Place) -> Definition | None:
        folder = os.path.dirname(problem.source.name)
        others: list[Definition] = []
        names = [f"{stem}{ending}" for ending in _endings_like(problem.source.name) for stem in ("domain", wanted)]
        for candidate in dict.fromkeys(name for name in names if not set(name) & set("/\\\0")):
            name = beside(folder, candidate)
            if name == os.path.normpath(problem.source.name) or not self._exists(name):
                continue
            found = [each for each in self._definitions(name) if each.kind == "domain"]
            for each in found:
                if each.name == wanted or not wanted:
                    return each
            others += found
        hint = f"name its file as well, or put it beside this one as {' or '.join(names[:2])}"
        if others:
            hint = f'{os.path.basename(others[0].source.name)} defines "{others[0].name}"; {hint}'
        self.findings.add(place, f'there is no domain "{wanted}" here', hint)
        return None

    def _exists(self, name: str) -> bool:
        return lies_within(Path(name), self._within) and os.path.isfile(name)


def _endings_like(name: str) -> tuple[str, ...]:
    """The endings of the file's format, its own first."""
    own = Path(name).suffix
    return (own, *(each for each in (PDDL if own.lower() in PDDL else PKS) if each != own.lower()))


def _format_of(name: str) -> Format:
    """The reader of a file's format; only that one is loaded."""
    if Path(name).suffix.lower() in PDDL:
        from kabo.language.pddl.problem import Pddl

        return Pddl()
    from kabo.language.pks.problem import Pks

    return Pks()
