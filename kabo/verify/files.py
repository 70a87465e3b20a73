"""Checks that the input files have not changed, by comparing each hash in the plan with the current file."""

import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path

from kabo.language import file_of, recorded_files
from kabo.plan import Plan
from kabo.verify.report import Finding


def check_files(plan: Plan, name: str, folder: Path, files: Mapping[str, str]) -> Iterator[Finding]:
    """The findings about input files that have changed since the plan was made.

    Args:
        plan: the plan with its recorded hashes.
        name: the problem's name.
        folder: the problem's folder, to which recorded paths are relative.
        files: the hashes of all files that were read now, by path relative to `folder`.
    """
    if plan.problem != name:
        yield Finding(None, f'made for another problem: "{plan.problem}", not "{name}"')
    # Older plans of kabo name installed files by their path.
    named = recorded_files([(file_of(path, folder), "") for path in plan.files], folder)
    for path, recorded in sorted(plan.files.items()):
        now = files.get(path) or _hash(file_of(path, folder))
        if now is None:
            yield Finding(None, f"made for other files: {path} does not exist any more")
        elif now != recorded:
            yield Finding(None, f"made for other files: {path} has changed since")
    yield from _models(plan)
    for path in sorted(files.keys() - plan.files.keys() - named.keys()):
        yield Finding(None, f"made for other files: {path} is not recorded in the plan")


def _models(plan: Plan) -> Iterator[Finding]:
    """Findings about parameters that were learned from a model whose hash the plan does not record."""
    for name, node in plan.nodes.items():
        for each in node.learned:
            if each.model not in plan.files:
                yield Finding(name, f"learned from {each.model}, which is not recorded in the plan")


def _hash(path: Path) -> str | None:
    try:
        return "sha256:" + hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return None
