"""How large the part of the verifier is that must be trusted, and what it shares with the planner.

Source: docs/explanation/trust.md.
"""

import ast
import io
import tokenize
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]
VERIFY = REPOSITORY / "kabo" / "verify"
SHARED = {"kabo.language", "kabo.plan", "kabo.scene", "kabo.meshes", "kabo.errors", "kabo.arrays", "kabo.lazy"}
SHARED |= {
    "kabo.displays",
    "kabo.phases",
    "kabo.given",
}  # they show reports, tell whoever waits, and refuse arguments
IGNORED = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENDMARKER,
}


def parts() -> dict[str, list[Path]]:
    """The parts of the trusted core; the replay is none of it."""
    files = [path for path in sorted(VERIFY.rglob("*.py")) if "replay" not in path.relative_to(VERIFY).parts]
    worlds = [path for path in files if "knowledge" in path.relative_to(VERIFY).parts]
    certificate = [path for path in files if path.relative_to(VERIFY).parts[0].startswith("certificate")]
    certificate.append(VERIFY / "motion" / "chord_bounds.py")  # what it claims of a chord
    trajectories = [path for path in files if "traject" in str(path.relative_to(VERIFY))]
    added = [VERIFY / "motion" / "added.py"]
    others = {*worlds, *certificate, *trajectories, *added}
    return {
        "possible worlds": worlds,
        "certificate": certificate,
        "trajectories": trajectories,
        "added bodies": added,
        "motion": [path for path in files if path not in others],
    }


def lines_of_code(path: Path) -> int:
    """Lines that are not blank, comments or docstrings."""
    source = path.read_text()
    documents: set[int] = set()
    for node in ast.walk(ast.parse(source)):
        body = getattr(node, "body", None)
        if not isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) or not body:
            continue
        first = body[0]
        if (
            isinstance(first, ast.Expr)
            and isinstance(first.value, ast.Constant)
            and isinstance(first.value.value, str)
        ):
            documents.update(range(first.lineno, (first.end_lineno or first.lineno) + 1))
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    lines = {line for t in tokens if t.type not in IGNORED for line in range(t.start[0], t.end[0] + 1)}
    return len(lines - documents)


BOUNDS = {"possible worlds": 2000, "certificate": 1050, "trajectories": 750, "added bodies": 160, "motion": 3550}


@pytest.mark.parametrize(("part", "bound"), BOUNDS.items())
def test_each_part_of_the_trusted_core_is_small(part, bound):
    assert sum(map(lines_of_code, parts()[part])) <= bound
    page = (REPOSITORY / "docs" / "explanation" / "trust.md").read_text()
    assert f"| {bound:,} |" in next(line for line in page.splitlines() if line.startswith(f"| {part}"))


def imported(path: Path) -> set[str]:
    """The modules of kabo that a file imports."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module)
        elif isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
    return {name for name in names if name.split(".")[0] == "kabo"}


def test_what_the_core_shares_with_the_planner_is_what_the_page_names():
    found = {
        ".".join(name.split(".")[:2])
        for files in parts().values()
        for path in files
        for name in imported(path)
        if not name.startswith("kabo.verify")
    }
    assert found <= SHARED, found
    page = (REPOSITORY / "docs" / "explanation" / "trust.md").read_text()
    assert all(name.replace(".", "/") in page for name in found)


def test_possible_worlds_know_nothing_of_the_replay():
    """Only the file that says who judges knows both."""
    for path in parts()["possible worlds"]:
        uses = any(name.startswith("kabo.verify.knowledge.replay") for name in imported(path))
        assert uses is (path.name == "judging.py"), path
