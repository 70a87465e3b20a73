"""Loads a Problem from paths of YAML files: all files that belong together, with all findings at once."""

import os
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path

from kabo.errors import Diagnostic, InputError
from kabo.language.findings import Findings
from kabo.language.formulas import Place
from kabo.language.problem import Problem
from kabo.language.scene_description import SceneDescription
from kabo.language.source import UnreadableError, beside, read_source
from kabo.language.yaml.documents import Mapping, YamlNode, read_document
from kabo.language.yaml.domain_file import DomainReading, read_domain
from kabo.language.yaml.exploration_file import read_exploration
from kabo.language.yaml.problem_file import read_problem
from kabo.language.yaml.scenes.scene_file import SceneReading, read_scene
from kabo.language.yaml.sensors_file import read_sensors
from kabo.language.yaml.task_file import read_task
from kabo.language.yaml.truth_file import read_truth


@dataclass
class _Loading:
    """One reading of a problem and the files it names."""

    findings: Findings = field(default_factory=Findings)
    digests: dict[str, str] = field(default_factory=dict)  # by real path
    tasks: set[str] = field(default_factory=set)  # task files beside the domain that its calls name
    within: Path | None = None  # no file outside of this folder is opened

    def document(self, name: str, named_at: Place | None = None, *, aliases: bool = False) -> Mapping | None:
        """The document of the file called `name`; a missing one is reported where it is named."""
        try:
            source = read_source(Path(name), name, within=self.within)
        except UnreadableError as error:
            self._report(name, named_at, error)
            return None
        self.digests[name] = source.digest
        return read_document(source, self.findings, aliases=aliases)

    def _report(self, name: str, named_at: Place | None, error: UnreadableError) -> None:
        if error.offset is not None or named_at is None:
            self.findings.add_unreadable(name, error, self.within)
            return
        shown = os.path.relpath(name, os.path.dirname(named_at.file) or ".").replace(os.sep, "/")
        hint = error.hint or self.findings.near_file(Path(name), self.within)
        self.findings.add(named_at, f'"{shown}": {error.message}', hint)

    def problem(self, root: Mapping, name: str) -> Problem | None:
        """The problem of a document, with its domain and scene."""
        folder = os.path.dirname(name)
        domain = self._domain(root, folder)
        scene = self._scene(root, folder)
        problem = read_problem(root, domain, scene, self.findings)
        if problem is None or domain is None:
            return None
        self.note(domain)  # a test in the goal may have called more
        return replace(problem, files=self._relative_to(folder))

    def _domain(self, root: Mapping, folder: str) -> DomainReading | None:
        node = root.get("domain")
        written = _path_of(node) or "domain.yaml"
        named_at = (node or (root.key("problem") if "problem" in root.entries else root)).place
        document = self.document(beside(folder, written), named_at)
        if document is None:
            return None
        if kind_of(document) != "domain":
            self.findings.add(named_at, f"{written} is no domain: it has none of the keys of one")
            return None
        return self.read_domain(document)

    def read_domain(self, document: Mapping) -> DomainReading:
        """The domain of a document, with the task files that it calls."""
        reading = read_domain(document, self.findings, within=self.within)
        self.note(reading)
        return reading

    def note(self, reading: DomainReading) -> None:
        """Records the task files that a domain has read as files of this reading."""
        digests = reading.tasks.digests
        self.digests |= digests | reading.tasks.models
        self.tasks.update(digests)

    def _scene(self, root: Mapping, folder: str) -> SceneReading | None:
        node = root.get("scene")
        written = _path_of(node)
        if node is None or written is None:
            if node is not None:
                self.findings.add(node.place, "`scene` must be the path of a scene file")
            return None
        document = self.document(beside(folder, written), node.place)
        if document is None:
            return None
        if kind_of(document) != "scene":
            self.findings.add(node.place, f"{written} is no scene: it has none of the keys of one")
            return None
        return read_scene(document, root, self.findings, within=self.within)

    def _relative_to(self, folder: str) -> dict[str, str]:
        base = folder or "."
        return {os.path.relpath(name, base).replace(os.sep, "/"): digest for name, digest in self.digests.items()}


def _path_of(node: YamlNode | None) -> str | None:
    text = getattr(node, "text", None)
    return text if isinstance(text, str) and text.strip() and "\0" not in text else None


_UNKNOWN_KIND = (
    "this is no domain (key `domain`), problem (key `problem`), scene (key `scene`), task (key `stages`), "
    "exploration (key `exploration`), sensor file (key `sensors`) or truth file (key `truth`)"
)
_TELLING = {
    "problem": {"problem", "goal", "initial"},
    "domain": {"actions", "predicates", "types", "domain"},
    "scene": {"scene", "epsilon", "robots"},
    "task": {"stages"},
    "exploration": {"exploration", "trial", "outcomes"},
    "sensors": {"sensors"},
    "truth": {"truth"},
}


def kind_of(root: Mapping) -> str | None:
    """The kind of a document, judged by keys that only one kind of file has; None if it has no such key."""
    keys = root.entries.keys()
    for kind, telling in _TELLING.items():
        if keys & telling:
            return kind
    return None


def load_problem(path: str | Path, *, within: Path | None = None) -> Problem:
    """The problem of a file, with its domain and the description of its scene; opens no mesh and no URDF.

    Args:
        path: the problem file.
        within: if given, no file outside of this folder is opened (links are followed first).

    Raises:
        InputError: with every diagnostic of all files that belong to the problem.
    """
    loading = _Loading(within=within)
    name = os.fspath(path)
    root = loading.document(name)
    problem = None
    kind = None if root is None else kind_of(root)
    if root is not None and kind != "problem":
        message = _UNKNOWN_KIND if kind is None else f"a problem is needed here, this is a {kind}"
        of_task = "`kabo task plan` plans a task; what it finds is verified in the scene: kabo verify SCENE PLAN"
        hint = of_task if kind == "task" else None
        loading.findings.add(_first_key(root), message, hint)
    elif root is not None:
        problem = loading.problem(root, name)
    if problem is None or loading.findings.errors:
        raise InputError(loading.findings.diagnostics)
    return problem


def load_scene_description(
    path: str | Path, *, within: Path | None = None, whole: bool = True
) -> SceneDescription:
    """The description of the scene in a scene file, or of a problem's scene with the bodies that the problem adds.

    Args:
        path: the file.
        within: if given, no file outside of this folder is opened (links are followed first).
        whole: whether a scene file has all bodies; False where it is only looked at, and problems may add some.

    Raises:
        InputError: with every diagnostic.
    """
    loading = _Loading(within=within)
    name = os.fspath(path)
    root = loading.document(name)
    scene = None
    if root is not None and kind_of(root) == "problem":
        problem = loading.problem(root, name)
        scene = None if problem is None else problem.scene
        if problem is not None and scene is None:
            loading.findings.add(_first_key(root), "this problem has no scene")
    elif root is not None and kind_of(root) == "scene":
        scene = read_scene(root, None, loading.findings, within=within, whole=whole).description
    elif root is not None:
        loading.findings.add(_first_key(root), "a scene is needed here, or a problem with one")
    if scene is None or loading.findings.errors:
        raise InputError(loading.findings.diagnostics)
    return scene


def check_files(paths: Iterable[str | Path]) -> list[Diagnostic]:
    """All diagnostics of YAML files of any kind, and of the files that they name, sorted by place."""
    found: dict[Diagnostic, None] = {}
    for path in paths:
        loading = _Loading()
        name = os.fspath(path)
        root = loading.document(name)
        if root is not None and kind_of(root) == "task":  # the one kind of file that may have anchors
            loading = _Loading()
            root = loading.document(name, aliases=True)
        if root is not None:
            _check(loading, root, name)
        found.update(dict.fromkeys(loading.findings.diagnostics))
    return sorted(found, key=lambda d: (d.file, d.line, d.column, d.message))


def own_task_files(path: str | Path) -> list[str]:
    """The user's task files that a file depends on: itself if it is one, or those that its domain calls."""
    loading = _Loading()
    name = os.fspath(path)
    root = loading.document(name, aliases=True)
    kind = None if root is None else kind_of(root)
    if root is None or kind is None:
        return []
    if kind == "task":
        return [name]
    _check(loading, root, name)
    return sorted(loading.tasks)


def is_exploration(path: str | Path) -> bool:
    """Whether a file is an exploration; False if it cannot be read."""
    root = _Loading().document(os.fspath(path))
    return root is not None and kind_of(root) == "exploration"


def kind_of_file(path: str | Path) -> str | None:
    """What a YAML file is: domain, problem, scene, task, exploration, sensors or truth; None if it is none of them.

    Raises:
        InputError: the file cannot be read, or is no YAML.
    """
    loading = _Loading()
    root = loading.document(os.fspath(path), aliases=True)
    if root is None:
        raise InputError(loading.findings.diagnostics)
    return kind_of(root)


def _check(loading: _Loading, root: Mapping, name: str) -> None:
    kind = kind_of(root)
    if kind == "problem":
        loading.problem(root, name)
    elif kind == "domain":
        loading.read_domain(root)
    elif kind == "scene":
        read_scene(root, None, loading.findings, whole=False)
    elif kind == "task":
        read_task(root, loading.findings)
    elif kind == "exploration":
        read_exploration(root, loading.findings)
    elif kind == "sensors":
        read_sensors(root, None, loading.findings)
    elif kind == "truth":
        read_truth(root, None, loading.findings)
    else:
        loading.findings.add(_first_key(root), _UNKNOWN_KIND)


def _first_key(root: Mapping) -> Place:
    first = next(iter(root.entries), None)
    return root.place if first is None else root.key(first).place
