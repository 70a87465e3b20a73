"""The laws of the house that a machine can judge: who may import whom, what starts light, what every file says."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

import kabo
from kabo.cli.main import COMMANDS

REPOSITORY = Path(__file__).parents[1]
SOURCES = sorted((REPOSITORY / "kabo").rglob("*.py"))
HEAVY = ("numpy", "numba", "scipy", "trimesh", "pinocchio", "coal", "zenoh", "rich", "yaml", "lark", "msgspec")
EDGES = {
    "kabo/cli/main.py",
    "kabo/cli/own_code.py",
    "kabo/service/answering.py",
    "kabo/service/server.py",  # closes what it has opened, and raises the same error again
    "kabo/remote/zenoh_robot.py",  # likewise
    "kabo/service/worker.py",
    "kabo/children.py",
    "kabo/meshes/reading.py",
    "kabo/tasks/core/run/planning.py",  # gives the job back and raises the same error again
    "kabo/tasks/core/task.py",  # gives the jobs back and raises the same error again
    "kabo/service/workers.py",
    "kabo/exporting/stepping.py",  # raises the same error again in the thread that asks for steps
    "kabo/tasks/core/run/workers.py",
}
# What a process remembers beyond a call, and why nobody can get another's answer from it [decision 026].
REMEMBERED = {
    "kabo/simulation/masses.py": {"_MADE"},  # by the mesh's digest and the density
    "kabo/whole_files.py": {"_hashes"},  # by size and times of a file, unless it has changed lately
    "kabo/compilation/cache.py": {"_private_folder", "_takes_files", "_warn_of"},  # of this installation
    "kabo/compilation/compiling.py": {"_sources_digest", "_numba", "_links"},
    "kabo/compilation/linking.py": {"whole_compiler", "part_compiler", "part"},
    "kabo/exploration/gaussian_processes.py": {"_sklearn", "_libraries"},  # loaded code
    "kabo/finite_domain/search/blind_search.py": {"_compiled"},  # loaded code
    "kabo/finite_domain/heuristics/landmark_bound.py": {"_kernel"},
    "kabo/finite_domain/search/novelty_search.py": {"_compiled"},
    "kabo/finite_domain/heuristics/relaxation.py": {"_load"},
    "kabo/geometry/bounding/verified_parts.py": {"_PROVEN"},  # by content
    "kabo/geometry/collision/exact_surfaces.py": {"_SURFACES"},  # by the arrays and elements themselves
    "kabo/geometry/collision/exact_view.py": {"path"},  # within one call
    "kabo/geometry/collision/motions.py": {"_STANDING"},  # for as long as the body is there
    "kabo/geometry/collision/part_trees.py": {"_REFINED"},  # as long as the enclosure is there
    "kabo/geometry/collision/placed_bodies.py": {"sources_of"},  # by the enclosures themselves, a few
    "kabo/geometry/collision/sight_lines.py": {"_icosphere"},  # constants
    "kabo/geometry/parts.py": {"ball_around"},  # a constant
    "kabo/geometry_server/context.py": {"_SHARED"},  # by numbers that are given once; for as long as it is there
    "kabo/geometry_server/open_turns.py": {"_TURNS"},  # by content
    "kabo/geometry_server/preparation/enclosures.py": {"_ENCLOSURES"},  # by content
    "kabo/kinematics/families.py": {"_FAMILIES"},  # by content
    "kabo/knowledge/grounding/unsupported.py": {"_parts_of"},  # of classes of kabo
    "kabo/language/yaml/procedures.py": {"library_names", "library_signature"},  # of this installation
    "kabo/language/yaml/syntax.py": {"_parser"},
    "kabo/language/yaml/task_file.py": {"_DESCRIPTIONS"},  # by content
    "kabo/meshes/reading.py": {"_TRIANGLES"},  # by content
    "kabo/pictures/labels.py": {"font"},  # of this installation
    "kabo/scene/robots.py": {"_SHARED"},  # as contexts
    "kabo/geometry/collision/tight_parts.py": {"_MADE"},  # by content
    "kabo/tasks/binding.py": {"library_task"},  # of this installation
    "kabo/tasks/files/costs.py": {"_registered"},  # by modules that a person names on the command line
    "kabo/tasks/files/registry.py": {"_registered"},
    "kabo/tasks/learned/models.py": {"_ANSWERS"},  # by content
    "kabo/trials/registry.py": {"_registered"},  # as of stages
    "kabo/verify/certificate/exact.py": {"_pi"},  # a constant
    "kabo/verify/certificate/parts.py": {"_COVERED"},  # by content
    "kabo/verify/knowledge/replay/mutable_knowledge.py": {"_spelled"},  # by value
    "kabo/verify/knowledge/replay/states.py": {"symbols_of", "in_order"},  # by value
    "kabo/ways/searching.py": {"_free", "_still", "_nothing"},  # constants
}
MEMORIES = {"ContentCache", "OrderedDict", "defaultdict", "deque", "dict", "list", "set"}


def relative(path: Path) -> str:
    """A source file as the repository names it."""
    return path.relative_to(REPOSITORY).as_posix()


def loaded_by(program: str) -> set[str]:
    """The heavy packages that a program loads, run in a process of its own."""
    report = f"{program}\nimport sys; print('LOADED', *(m for m in {HEAVY!r} if m in sys.modules))"
    command = [sys.executable, "-c", report]
    done = subprocess.run(command, capture_output=True, text=True, cwd=REPOSITORY, check=True)
    return set(done.stdout.rsplit("LOADED", 1)[1].split())


def test_imports_go_down_and_the_verifier_shares_no_code_with_what_it_judges():
    done = subprocess.run(
        [Path(sys.executable).with_name("lint-imports"), "--no-cache"],
        capture_output=True,
        text=True,
        cwd=REPOSITORY,
        check=False,
    )
    assert done.returncode == 0, done.stdout


def test_importing_kabo_loads_nothing_heavy():
    assert loaded_by("import kabo") == set()


@pytest.mark.parametrize("arguments", [["--help"], *([command.NAME, "--help"] for command in COMMANDS)])
def test_help_loads_nothing_heavy(arguments):
    program = f"from kabo.cli import main\ntry:\n    main({arguments!r})\nexcept SystemExit:\n    pass"
    assert loaded_by(program) == set()


def test_checking_files_loads_no_kernels(tmp_path):
    domain = tmp_path / "domain.yaml"
    domain.write_text("domain: d\ntypes: [t]\nactions:\n  a: {parameters: {x: t}}\n")
    program = f"from kabo.cli import main\nassert main(['check', {str(domain)!r}]) == 0"
    assert not loaded_by(program) & {"numba", "scipy", "trimesh", "pinocchio", "coal", "zenoh"}


def test_a_problem_without_a_scene_is_solved_without_kernels(tmp_path):
    problem = REPOSITORY / "tests" / "acceptance" / "parcels" / "one.yaml"
    arguments = ["solve", str(problem), "-o", str(tmp_path / "plan.json")]
    program = f"from kabo.cli import main\nassert main({arguments!r}) == 0"
    assert not loaded_by(program) & {"numba", "scipy", "trimesh", "pinocchio", "coal", "zenoh", "rich"}


@pytest.mark.parametrize("path", SOURCES, ids=relative)
def test_a_module_says_why_it_exists_and_prints_only_in_cli(path):
    tree = ast.parse(path.read_text())
    assert ast.get_docstring(tree), "no docstring"
    calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call)]
    prints = [node.lineno for node in calls if isinstance(node.func, ast.Name) and node.func.id == "print"]
    assert not prints or relative(path).startswith("kabo/cli/")


def test_files_stay_small():
    lengths = {relative(path): len(path.read_text().splitlines()) for path in SOURCES}
    assert not {name: length for name, length in lengths.items() if length > 400}


MAX_KERNEL_ARGUMENTS = 10


def kernels_of(path: Path) -> list[ast.FunctionDef]:
    """The functions of a file that are compiled: those with a decorator that is called some kind of kernel."""
    functions = [node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.FunctionDef)]
    return [one for one in functions if any("kernel" in ast.unparse(each) for each in one.decorator_list)]


def test_no_kernel_takes_more_than_ten_arguments():
    """Arrays that belong together are passed as a NamedTuple of arrays."""
    found, many = 0, {}
    for path in SOURCES:
        for one in kernels_of(path):
            given = one.args
            count = len(given.posonlyargs) + len(given.args) + len(given.kwonlyargs)
            found += 1
            if count > MAX_KERNEL_ARGUMENTS:
                many[f"{relative(path)}: {one.name}"] = count
    assert found > 300
    assert not many


def test_no_named_tuple_is_generic_which_python_3_10_does_not_know():
    pattern = re.compile(r"^class (\w+)\(.*\bNamedTuple\b.*,|^class (\w+)\(.*, *NamedTuple\b", re.MULTILINE)
    assert not {relative(path) for path in SOURCES if pattern.search(path.read_text())}


def test_only_the_outer_edges_catch_every_exception():
    blind = re.compile(r"except (Base)?Exception\b(?! as error:\n\s+raise)|except\s*:")
    found = {relative(path) for path in SOURCES if blind.search(path.read_text())}
    assert found <= EDGES


def test_the_version_has_its_entry_in_the_changelog():
    changelog = (REPOSITORY / "CHANGELOG.md").read_text()
    assert re.search(rf"^## \[{re.escape(kabo.__version__)}\]", changelog, re.MULTILINE)


def test_every_name_of_the_facade_exists():
    missing = [name for name in kabo.__all__ if not hasattr(kabo, name)]
    assert not missing


def called(node: ast.expr) -> str:
    """The last word of what is called or named: `cache` of `functools.cache`, `ContentCache` of `ContentCache[int](…)`."""
    while isinstance(node, ast.Call | ast.Subscript):
        node = node.func if isinstance(node, ast.Call) else node.value
    return node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ""


def remembers(value: ast.expr | None) -> bool:
    """Whether a module's variable begins as an empty container, or as a memory."""
    if isinstance(value, ast.Dict | ast.List):
        return not (value.keys if isinstance(value, ast.Dict) else value.elts)
    if not isinstance(value, ast.Call):
        return False
    kind = called(value)
    return kind.startswith("Weak") or kind == "ContentCache" or (kind in MEMORIES and not value.args)


def remembered_in(tree: ast.Module) -> set[str]:
    """The functions and variables by which a module remembers something beyond a call."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            found |= {node.name for each in node.decorator_list if called(each) in ("cache", "lru_cache")}
        elif isinstance(node, ast.Global):
            found |= set(node.names)
    for node in tree.body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and remembers(node.value):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            found |= {each.id for each in targets if isinstance(each, ast.Name)}
    return found


def test_whatever_is_remembered_beyond_a_call_is_known_to_be_nobody_elses_answer():
    found = {relative(path): remembered_in(ast.parse(path.read_text())) for path in SOURCES}
    assert {name: names for name, names in found.items() if names} == REMEMBERED
