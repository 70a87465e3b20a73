"""What a type checker sees through the doors of the rooms: every public name with its type, every wrong call."""

import importlib
import pickle
import pkgutil
import re
import subprocess
import sys
from pathlib import Path

import pytest

import kabo
from kabo.lazy import lazy_names

REPOSITORY = Path(__file__).parents[1]
WRONG = """from kabo import GeometryServer, solve, load_problem

GeometryServer(42, epsilom="ten", nonsense=True).no_such_method()
solve(load_problem("p.yaml"), search="besst")
solve(load_problem("p.yaml")).statistics["expandd"]
"""
RIGHT = """from kabo import load_problem, solve, verify, verify_plan

result = solve(load_problem("p.yaml"), search="astar", geometry="exact", quality="good", geometry_order="lazy")
expanded: int = result.statistics["expanded"]
if result.plan is not None:
    print(expanded, result.plan.statistics.plan_actions, result.plan.to_dot())
    for report in (verify(load_problem("p.yaml"), result.plan), verify_plan(load_problem("p.yaml"), result.plan)):
        print(report.ok)
"""


def test_no_module_hides_a_public_name_of_its_lazy_room():
    hidden = []
    for room, names in rooms().items():
        package = importlib.import_module(room)
        if not hasattr(package, "__getattr__"):
            continue  # its names are bound after its modules are
        modules = {each.name for each in pkgutil.iter_modules(package.__path__) if not each.ispkg}
        hidden += [f"{room}.{name}" for name in names if name in modules]
    assert hidden == [], "whoever imports this module first finds it in place of the name"


def rooms() -> dict[str, list[str]]:
    """The public names of every room, and of every room inside a room."""
    packages = [each.name for each in pkgutil.walk_packages(kabo.__path__, "kabo.") if each.ispkg]
    found = {name: importlib.import_module(name) for name in ["kabo", *packages]}
    return {name: list(room.__all__) for name, room in found.items() if hasattr(room, "__all__")}


ROOMS = rooms()
LAZY = sorted(
    ".".join(path.parent.relative_to(REPOSITORY).parts) for path in REPOSITORY.glob("kabo/**/__init__.pyi")
)
NAMES = [f"{room}:{name}" for room, names in ROOMS.items() for name in names]


@pytest.fixture(scope="module")
def findings(tmp_path_factory) -> dict[str, dict[int, str]]:
    """What one run of mypy --strict says of three files, by file and line."""
    folder = tmp_path_factory.mktemp("types")
    lines = []
    for number, each in enumerate(NAMES):
        room, name = each.split(":")
        lines.append(f"from {room} import {name} as name_{number}; reveal_type(name_{number})")
    (folder / "names.py").write_text("\n".join(lines))
    (folder / "wrong.py").write_text(WRONG)
    (folder / "right.py").write_text(RIGHT)
    options = ["--config-file=", "--strict", "--ignore-missing-imports", "--follow-imports=silent"]
    shown = ["--no-error-summary", "--hide-error-context", "--no-pretty", f"--cache-dir={folder / 'cache'}"]
    files = [str(folder / f"{name}.py") for name in ("names", "wrong", "right")]
    command = [sys.executable, "-m", "mypy", *options, *shown, *files]
    done = subprocess.run(command, capture_output=True, text=True, cwd=REPOSITORY, check=False)
    found: dict[str, dict[int, str]] = {"names": {}, "wrong": {}, "right": {}}
    for file, number, text in re.findall(r"(\w+)\.py:(\d+): (.*)", done.stdout):
        found[file][int(number)] = f"{found[file].get(int(number), '')}{text}\n"
    assert found["names"], done.stdout + done.stderr
    return found


def test_every_public_name_of_every_room_has_a_type(findings):
    found = findings["names"]
    assert len(found) == len(NAMES) > 300
    untyped = {each: found[line] for line, each in enumerate(NAMES, 1) if is_untyped(found[line])}
    assert not untyped


def is_untyped(text: str) -> bool:
    """Whether mypy knows nothing of what it reveals, or finds no such name."""
    return re.search(r'^error: |Revealed type is "(Any|(builtins\.)?object)"', text, re.MULTILINE) is not None


def test_a_wrong_argument_of_a_public_name_is_refused_by_mypy(findings):
    assert "epsilom" in findings["wrong"][3] or "Unexpected keyword argument" in findings["wrong"][3]
    assert "no_such_method" in findings["wrong"][3]
    assert 'expected "Literal[' in findings["wrong"][4]
    assert 'Did you mean "expanded"?' in findings["wrong"][5]


def test_the_right_calls_are_not_refused_by_mypy(findings):
    assert findings["right"] == {}


@pytest.mark.parametrize("room", LAZY)
def test_every_name_of_a_stub_loads(room):
    module = importlib.import_module(room)
    assert {*module.__all__} <= {*dir(module)}
    assert not [name for name in module.__all__ if not hasattr(module, name)]


@pytest.mark.parametrize("room", LAZY)
def test_importing_all_names_of_a_lazy_room_gives_them_and_no_more(room):
    names: dict[str, object] = {}
    exec(f"from {room} import *", names)
    assert sorted(names.keys() - {"__builtins__"}) == ROOMS[room]


@pytest.mark.parametrize("room", [room for room in LAZY if room not in ("kabo", "kabo.tasks")])
def test_a_stub_offers_what_the_room_itself_has(room):
    stub = REPOSITORY.joinpath(*room.split(".")) / "__init__.pyi"
    homes = re.findall(r"^from (\S+) import", stub.read_text(), re.MULTILINE)
    assert homes and all(home.startswith(f"{room}.") for home in homes)


def test_an_unknown_name_is_refused_with_the_room_and_what_is_near():
    program = "import kabo\nkabo.sovle"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert "module 'kabo' has no attribute 'sovle'. Did you mean: 'solve'?" in done.stderr


@pytest.mark.parametrize(
    "line",
    [
        "import kabo.scene",
        "from kabo.scene import Scene",
        "from kabo.scene import Scene as World",
        "from kabo.scene import (Scene as Scene)",
        "from kabo.scene import Scene as Scene, Body as Body",
    ],
)
def test_an_import_of_another_form_is_refused_with_its_place(tmp_path, line):
    (tmp_path / "__init__.pyi").write_text(f'"""A room."""\n{line}\n')
    with pytest.raises(SyntaxError, match="__init__.pyi:2: an import here is written"):
        lazy_names("room", str(tmp_path / "__init__.py"))


@pytest.mark.parametrize("first", ["", "import kabo.verify.verification", "from kabo.verify import verify_plan"])
def test_the_facade_keeps_its_function_whatever_was_imported_first(first):
    program = f"{first}\nimport kabo\nfrom kabo.verify.verification import verify_plan\nprint(kabo.verify is verify_plan)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "True\n"


def test_public_functions_and_classes_are_pickled_by_their_home():
    for each in (kabo.verify, kabo.solve, kabo.Plan):
        assert pickle.loads(pickle.dumps(each)) is each
