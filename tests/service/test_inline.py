"""Problems with all their files in one message: what is packed, and what a worker refuses to open."""

import base64
import shutil
from pathlib import Path

import pytest

from kabo.errors import InputError
from kabo.language import load_problem
from kabo.options import SolveOptions
from kabo.requests import solve_file
from kabo.scene import load_scene
from kabo.service import pack_problem, problem_for
from kabo.service.inline import Forbidden, below, safe_name, unpack_problem
from kabo.service.messages import InlineFile, ProblemFiles, Status, Unreadable
from tests.support.bars import write_domain

REPOSITORY = Path(__file__).parents[2]
BARTENDER = REPOSITORY / "domains" / "bartender" / "four_bottles.yaml"
PARCELS = REPOSITORY / "tests" / "acceptance" / "parcels"


def unpacked(packed: dict, folder: Path) -> Path:
    """The problem file of a packed problem, unpacked into a folder."""
    decoded = {
        name: InlineFile(base64.b64decode(content["base64"])) if isinstance(content, dict) else content
        for name, content in packed["files"].items()
    }
    return folder / unpack_problem(ProblemFiles(packed["path"], decoded), folder)


def test_a_packed_scene_has_every_file_that_loading_it_reads(tmp_path):
    problem = load_problem(BARTENDER)
    scene = load_scene(problem.scene)
    path = unpacked(pack_problem(BARTENDER), tmp_path)
    moved = load_scene(load_problem(path, within=tmp_path).scene)
    assert sorted(moved.files.values()) == sorted(scene.files.values())
    assert all(file.resolve().is_relative_to(tmp_path.resolve()) for file in moved.files)
    for mesh in moved.files:
        stored = BARTENDER.parents[2] / mesh.resolve().relative_to(tmp_path.resolve())
        assert stored.with_name(stored.name + ".parts").exists() == mesh.with_name(mesh.name + ".parts").exists()


def test_models_of_tasks_are_packed_and_solved_with_elsewhere(tmp_path):
    here = write_domain(tmp_path / "here")
    packed = pack_problem(here)
    assert set(packed["files"]) > {"model.jsonl", "tasks/aim.yaml"}
    there = unpacked(packed, tmp_path / "there")
    answers = [solve_file(path, SolveOptions(), within=path.parent) for path in (here, there)]
    assert answers[0].plan is not None and answers[0].plan == answers[1].plan


def test_files_come_back_byte_for_byte(tmp_path):
    folder = tmp_path / "here"
    shutil.copytree(PARCELS, folder)
    text = (folder / "one.yaml").read_text().replace("\n", "\r\n") + "# ä\r\n"
    (folder / "one.yaml").write_bytes(text.encode())
    there = unpacked(pack_problem(folder / "one.yaml"), tmp_path / "there")
    assert there.read_bytes() == text.encode()


def test_a_path_is_sent_only_if_it_lies_below_the_root_of_the_server():
    chosen = problem_for(PARCELS / "one.yaml")
    status = Status("s", 0, 0, 1, 1, "0", 1000, None)
    assert "files" in chosen(status)
    rooted = Status("s", 0, 0, 1, 1, "0", 1000, str(PARCELS.resolve().parent))
    assert chosen(rooted) == {"path": "parcels/one.yaml"}


@pytest.mark.parametrize("name", ["../a", "/etc/passwd", "a/../../b", "", ".", "a\\..\\b", "a\0b", ".."])
def test_names_that_lead_out_are_forbidden(name, tmp_path):
    with pytest.raises(Forbidden):
        safe_name(name)
    with pytest.raises(Forbidden):
        unpack_problem(ProblemFiles("p", {name: "x"}), tmp_path)
    with pytest.raises(Forbidden):
        below(tmp_path, name)


def test_a_link_out_of_the_root_is_forbidden(tmp_path):
    (tmp_path / "root").mkdir()
    (tmp_path / "root" / "link").symlink_to(PARCELS)
    with pytest.raises(Forbidden):
        below(tmp_path / "root", "link/one.yaml")


@pytest.mark.parametrize(
    "files",
    [
        {},
        {"a.yaml": "domain: d"},
        {"a.yaml": "problem: a", "b.yaml": "problem: b"},
        {"a": "x", "a/b": "problem: b"},
        {"x" * 300: "problem: b"},
    ],
)
def test_files_of_which_none_is_the_problem_are_refused(files, tmp_path):
    with pytest.raises(Unreadable):
        unpack_problem(ProblemFiles(None, files), tmp_path)
    with pytest.raises(Unreadable):
        unpack_problem(ProblemFiles("other.yaml", files), tmp_path)


def test_the_problem_among_the_files_is_recognised(tmp_path):
    files = {path.name: path.read_text() for path in (PARCELS / "domain.yaml", PARCELS / "one.yaml")}
    assert str(unpack_problem(ProblemFiles(None, files), tmp_path)) == "one.yaml"


def test_a_problem_that_names_files_elsewhere_reads_none_of_them(tmp_path):
    secret = tmp_path / "secret.yaml"
    secret.write_text("password: tulip\n")
    folder = tmp_path / "request"
    folder.mkdir()
    (folder / "p.yaml").write_text("problem: p\ndomain: ../secret.yaml\nobjects: {}\ngoal: 'true'\n")
    answer = solve_file(folder / "p.yaml", SolveOptions(), within=folder)
    assert answer.body["status"] == "invalid"
    assert "tulip" not in str(answer.error) and "password" not in str(answer.error)
    assert "may be read" in str(answer.error)


def test_a_scene_that_names_meshes_elsewhere_is_refused(tmp_path):
    mesh = REPOSITORY / "meshes" / "bottle"
    (tmp_path / "scene.yaml").write_text(
        f"scene: s\nepsilon: 0.01\nrobots: {{}}\nobjects:\n  thing: {{mesh: {next(mesh.glob('*.stl'))}}}\n"
    )
    shutil.copy(PARCELS / "domain.yaml", tmp_path)
    text = (PARCELS / "one.yaml").read_text().replace("objects:", "scene: scene.yaml\nobjects:", 1)
    (tmp_path / "p.yaml").write_text(text)
    with pytest.raises(InputError, match="be read"):
        raise solve_file(tmp_path / "p.yaml", SolveOptions(), within=tmp_path).error
