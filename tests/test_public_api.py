"""What `import kabo` offers, as an editor shows it: a docstring for every name and parameter, and examples that run."""

import ast
import doctest
import inspect
import re
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

import kabo

REPOSITORY = Path(__file__).parents[1]
NAMES = [
    name for name in kabo.__all__ if name != "__version__" and not isinstance(getattr(kabo, name), ModuleType)
]
FUNCTIONS = [name for name in NAMES if inspect.isfunction(getattr(kabo, name))]
CLASSES = [name for name in NAMES if inspect.isclass(getattr(kabo, name))]
WITH_EXAMPLES = [name for name in FUNCTIONS + CLASSES if "Example:" in (inspect.getdoc(getattr(kabo, name)) or "")]


def methods_of(kind: type) -> Iterator[tuple[str, object]]:
    """The public methods and properties that a class of kabo has itself."""
    for name, value in vars(kind).items():
        field = name in getattr(kind, "__dataclass_fields__", {})
        if not name.startswith("_") and not field and (inspect.isfunction(value) or isinstance(value, property)):
            yield name, value


def test_dir_lists_what_is_offered_and_nothing_else():
    program = "import kabo, kabo.cli; print(*(n for n in dir(kabo) if not n.startswith('__')))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.split() == sorted(kabo.__all__)


@pytest.mark.parametrize("name", NAMES)
def test_every_public_name_says_what_it_is(name):
    told = inspect.getdoc(getattr(kabo, name))
    assert told and len(told.splitlines()[0]) > 10, name


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_parameter_of_a_public_function_is_explained_and_every_error_is_named(name):
    function = getattr(kabo, name)
    told = inspect.getdoc(function)
    parameters = [each for each in inspect.signature(function).parameters.values() if each.name != "options"]
    unexplained = [
        each.name for each in parameters if not re.search(rf"^\s+(\w+, )*{each.name}(, \w+)*:", told, re.MULTILINE)
    ]
    assert not unexplained
    raised = set(re.findall(r"^ +(\w+): ", told.partition("Raises:")[2], re.MULTILINE))
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    named = {
        node.exc.func.id
        for node in ast.walk(tree)
        if isinstance(node, ast.Raise)
        and isinstance(node.exc, ast.Call)
        and isinstance(node.exc.func, ast.Name)
        and node.exc.func.id.endswith("Error")
    }
    assert named <= raised, "raised in its own lines"


@pytest.mark.parametrize("name", CLASSES)
def test_every_public_method_of_a_public_class_says_what_it_does(name):
    assert not [method for method, value in methods_of(getattr(kabo, name)) if not inspect.getdoc(value)]


@pytest.mark.parametrize("name", WITH_EXAMPLES)
def test_the_example_of_a_public_function_runs(name, monkeypatch, tmp_path):
    for folder in ("domains", "examples", "meshes"):
        (tmp_path / folder).symlink_to(REPOSITORY / folder)
    monkeypatch.chdir(tmp_path)
    function = getattr(kabo, name)
    found = doctest.DocTestFinder(recurse=False).find(function, name, globs={"kabo": kabo})
    assert sum(len(each.examples) for each in found) > 0, "no example"
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    said: list[str] = []
    for each in found:
        runner.run(each, out=said.append)
    assert not runner.failures, "".join(said)
