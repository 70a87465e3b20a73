"""Source files as trees: classes, functions, fields and their comments, without importing what they describe."""

import ast
import tokenize
from dataclasses import dataclass
from functools import cache
from io import StringIO
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent


@dataclass(frozen=True)
class Source:
    """A file: its text, its tree, and the comments at the ends of its lines."""

    text: str
    tree: ast.Module
    comments: dict[int, str]

    def segment(self, node: ast.AST) -> str:
        """The text of a piece on one line."""
        return " ".join((ast.get_source_segment(self.text, node) or "").split())

    def find(self, name: str) -> ast.stmt | None:
        """The class, function or assignment of that name at the top of the file; of several the last one."""
        found = [node for node in self.tree.body if name in defined_by(node)]
        return found[-1] if found else None

    def comment(self, node: ast.stmt) -> str:
        """The comment behind a statement, or on the lines just below it that hold nothing else."""
        return self.comments.get(node.end_lineno or 0, "")


@cache
def source(path: Path) -> Source:
    """The file at a path."""
    text = path.read_text()
    tokens = tokenize.generate_tokens(StringIO(text).readline)
    comments = {
        each.start[0]: each.string.lstrip("#: ").strip() for each in tokens if each.type == tokenize.COMMENT
    }
    return Source(text, ast.parse(text), comments)


def defined_by(node: ast.stmt) -> list[str]:
    """The names that a statement at the top of a file defines."""
    if isinstance(node, ast.ClassDef | ast.FunctionDef):
        return [node.name]
    if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
        return [node.target.id]
    if isinstance(node, ast.Assign):
        return [target.id for target in node.targets if isinstance(target, ast.Name)]
    return []


def module_path(module: str) -> Path:
    """The file of a module: of a package its stub, if it has one."""
    path = ROOT.joinpath(*module.split("."))
    candidates = (path.with_suffix(".py"), path / "__init__.pyi", path / "__init__.py")
    return next(each for each in candidates if each.exists())


def resolve(module: str, name: str) -> tuple[Source, ast.stmt] | None:
    """Where a public name of a module is defined, followed through stubs and imports; None if that is not in kabo."""
    here = source(module_path(module))
    if (found := here.find(name)) is not None:
        return here, found
    for origin, given, known_as in imported(module):
        if known_as == name:
            return None if is_module(origin, given) else resolve(origin, given)
        if given == "*" and (star := resolve(origin, name)) is not None:
            return star
    return None


def imported(module: str) -> list[tuple[str, str, str]]:
    """What a module imports from kabo: from where, by which name there, and by which name here."""
    return [
        (node.module, alias.name, alias.asname or alias.name)
        for node in source(module_path(module)).tree.body
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("kabo")
        for alias in node.names
    ]


def is_module(origin: str, name: str) -> bool:
    """Whether a name of a package is a module or package inside it, which its own page describes."""
    path = ROOT.joinpath(*origin.split("."), name)
    return path.is_dir() or path.with_suffix(".py").exists()


def names_of(module: str) -> list[str]:
    """The public names of a module that has a stub, in the order of the stub."""
    found: list[str] = []
    for origin, given, known_as in imported(module):
        found += names_of(origin) if given == "*" else [known_as]
    return [name for name in dict.fromkeys(found) if not name.startswith("_")]
