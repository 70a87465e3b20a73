"""Inputs that once ended in a traceback, "a defect of kabo", a hang or nonsense: each gets one sentence with its place."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

from kabo.cli.main import main
from kabo.errors import InputError, MeshError
from kabo.geometry import enclosing_parts
from kabo.geometry_server import GeometryServer
from kabo.language import load_problem, load_scene_description
from kabo.meshes import Mesh, load_mesh
from kabo.plan import plan_from_json
from kabo.requests import check_files
from kabo.scene import Scene, load_scene
from kabo.service import messages

CORPUS = Path(__file__).parents[1] / "fuzz/corpus"
HOME = Path(__file__).parents[2]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The small scene of the fuzzer, to be changed."""
    shutil.copytree(CORPUS, tmp_path / "small")
    return tmp_path / "small"


def change(path: Path, *pairs: tuple[str, str]) -> None:
    text = path.read_text()
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new, 1)
    path.write_text(text)


def loaded(folder: Path) -> Scene:
    return load_scene(load_scene_description(folder / "scene.yaml"))


def refused(folder: Path) -> str:
    with pytest.raises(InputError) as caught:
        GeometryServer(loaded(folder))
    for finding in caught.value.diagnostics:
        assert finding.line >= 1 and finding.file not in {"scene", "mesh"}
    return str(caught.value)


# ------------------------------------------------------------------------------------------------ URDF
@pytest.mark.parametrize(
    ("old", "new", "line", "said"),
    [
        ('size="0.1 0.1 0.1"', 'size="a b c"', 2, '`size` of <box> must be 3 numbers, "a" is none'),
        ('size="0.1 0.1 0.1"', 'size="1 1"', 2, '`size` of <box> must be 3 numbers, this is "1 1"'),
        ('size="0.1 0.1 0.1"', 'size="0 1 1"', 2, "must be above 0"),
        ('multiplier="2"', 'multiplier="x"', 18, '`multiplier` of <mimic> must be a number, "x" is none'),
        ('multiplier="2"', 'multiplier="1_0"', 18, '"1_0" is none'),
        ('<limit lower="-2" upper="2" velocity="1" effort="1"/>', "", 9, "is revolute and has no <limit>"),
        ('xyz="0 0 0.05"', 'xyz="0 0"', 9, '`xyz` of <origin> must be 3 numbers, this is "0 0"'),
        ('xyz="0 0 0.05"', 'xyz="0 0 1e300"', 9, "`xyz` of <origin> is too large: 1e300"),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 0 0"/>', 10, "has no direction"),
        ('child link="upper"', 'child link="uper"', 9, 'names the unknown link "uper"'),
        ('type="revolute"', 'type="screw"', 9, 'has the unknown type "screw"'),
        ('lower="-2" upper="2"', 'lower="2" upper="-2"', 10, "lower limit 2 above its upper one -2"),
        ('<link name="hand">', '<link name="lower">', 5, "there are two of"),
        ('<robot name="small">', '<!DOCTYPE r [<!ENTITY a "b">]><robot name="small">', 1, "defines XML entities"),
        ("</robot>", "", None, "is no XML"),
        ('<origin xyz="0 0 0.3"/>', '<origin xzy="0 0 0.3"/>', 11, "<origin> has no `xzy`"),
        (
            '<collision><origin xyz="0 0 0.15"/>',
            "<colision/><collision>",
            3,
            "unknown element <colision> in <link>",
        ),
        ('<sphere radius="0.02"/>', '<sphere radius="0.02"/><box size="1 1 1"/>', 5, "a <geometry> has one shape"),
        ('<parent link="base"/>', '<parent link="base"/><parent link="hand"/>', 9, "has two of <parent>"),
    ],
)
def test_a_urdf_is_refused_at_its_line(folder: Path, old: str, new: str, line: int | None, said: str) -> None:
    change(folder / "robot.urdf", (old, new))
    text = refused(folder)
    assert said in text
    assert f"robot.urdf:{line}:" in text or line is None


def test_a_robot_of_three_thousand_links_is_refused(folder: Path) -> None:
    links = "".join(f'<link name="l{i}"/>' for i in range(3000))
    (folder / "robot.urdf").write_text(f'<robot name="long">{links}</robot>')
    assert "3000 links are too many" in refused(folder)


def test_a_robot_whose_links_hang_on_themselves_is_refused(folder: Path) -> None:
    joint = '<joint name="{0}{1}" type="fixed"><parent link="{0}"/><child link="{1}"/></joint>'
    links = '<link name="a"/><link name="b"/>'
    (folder / "robot.urdf").write_text(
        f'<robot name="r">{links}{joint.format("a", "b")}{joint.format("b", "a")}</robot>'
    )
    assert "hangs on itself" in refused(folder)


# ------------------------------------------------------------------------------------------------ scenes
@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("epsilon: 0.01", "epsilon: 1e-9", "epsilon must lie between 1e-06 and 0.3 m, this is 1e-09 m"),
        ("epsilon: 0.01", "epsilon: 10", "epsilon must lie between"),
        ("position: [0.2, 0, -0.02]", "position: [1e300, 0, 0]", "reaches farther than 1000 m: 1e+300"),
        ("position: [0.2, 0, -0.02]", "position: [900, 0, 0]", 'body "table" reaches'),
        ("base: {position: [0, 0, 0.1]", "base: {position: [0, 999, 0]", 'robot "arm" reaches'),
        ("open: {pinch: 0.03}", "open: {pinch: 5}", "open: pinch = 5 is outside its limits [0, 0.03]"),
        ("fingers: {pinch: 0.02}", "fingers: {pinch: -1}", "pinch = -1 is outside its limits"),
        ("scale: 0.1", "scale: 1e5", 'body "rock" reaches'),
        ("box: [1.2, 1.6, 0.04]", "box: [1.2, 1.6, 1e-300]", "at least a micrometre"),
        ("radius: 0.03, height: 0.16", "radius: 1e-300, height: 0.16", "less than a micrometre"),
    ],
)
def test_a_scene_is_refused_at_its_line(folder: Path, old: str, new: str, said: str) -> None:
    change(folder / "scene.yaml", (old, new))
    assert said in refused(folder)


def test_the_epsilon_of_a_problem_has_bounds_too(folder: Path) -> None:
    change(folder / "problem.yaml", ("epsilon: 0.02", "epsilon: 3"))
    with pytest.raises(InputError, match="`epsilon` must lie between"):
        load_problem(folder / "problem.yaml")
    raw = b'{"id": "a", "problem": {"path": "p.yaml"}, "options": {"epsilon": 10}}'
    with pytest.raises(messages.Unreadable, match="0.3"):
        messages.read(messages.SolveRequest, raw)


def test_an_open_mesh_of_several_pieces_is_named_by_its_link(folder: Path) -> None:
    (folder / "tetra.off").write_text("OFF\n4 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n")
    moved = '<collision><origin xyz="0 0 0.1"/><geometry><mesh filename="tetra.off"/></geometry></collision>'
    change(folder / "robot.urdf", ('<link name="upper">', f'<link name="upper">{moved}'))
    server = GeometryServer(loaded(folder))
    said = r'robot.urdf:3:66: link "upper" of robot "arm": mesh file ".*tetra.off" is not closed'
    with pytest.raises(MeshError, match=said):
        server.surroundings.enclosure("arm.upper")
    with pytest.raises(MeshError, match='body "rock": mesh file ".*tetra.off" is not closed'):
        server.surroundings.enclosure("rock")


# ------------------------------------------------------------------------------------------------ meshes
def test_a_closed_box_that_is_inside_out_is_turned_and_told(folder: Path, tmp_path: Path) -> None:
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    box.invert()
    box.export(folder / "tetra.off")
    body = loaded(folder).bodies["rock"].mesh
    assert trimesh.Trimesh(body.vertices, body.faces, process=False).volume > 0.0
    (warning,) = (each for each in check_files([folder / "scene.yaml"]) if "inside out" in each.message)
    assert warning.severity == "warning" and warning.message == "turned 1 component that was inside out"
    made = enclosing_parts(Mesh(np.array(box.vertices), np.array(box.faces)), 0.004, cache=tmp_path)
    assert len(made.parts) == 1


def test_an_obj_may_hold_latin_1(tmp_path: Path) -> None:
    path = tmp_path / "café.obj"
    path.write_bytes(
        b"# caf\xe9\no tasse_\xe9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
    )
    assert len(load_mesh(path).faces) == 4


def test_a_flat_link_in_hulls_is_refused_by_its_name(folder: Path) -> None:
    (folder / "tetra.off").write_text("OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 2\n")
    change(folder / "scene.yaml", ("hulls: [base]", "hulls: [palm]"))
    with pytest.raises(MeshError, match='link "palm" of robot "arm": .* is flat'):
        GeometryServer(loaded(folder)).surroundings.enclosure("arm.palm")


def test_a_flat_mesh_is_no_region(folder: Path) -> None:
    (folder / "flat.off").write_text("OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 2\n")
    change(folder / "scene.yaml", ("box: [0.30, 1.20, 0.4]", "mesh: flat.off"))
    assert 'mesh file "flat.off" is flat' in refused(folder)


# ------------------------------------------------------------------------------------------------ command line
@pytest.mark.parametrize("command", ["solve", "request", "explain"])
@pytest.mark.parametrize("text", ["10", "1e-9"])
def test_an_epsilon_that_geometry_cannot_keep_is_no_option(
    command: str, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main([command, str(CORPUS / "problem.yaml"), "--epsilon", text])
    assert f"'{text}' is not a length from 1e-06 to 0.3 m" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words", [["solve", "--json", "--searc"], ["--json"], ["bound", "x.off", "--json", "--epsilon", "x"]]
)
def test_wrong_options_with_json_are_one_object(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(words)
    told = capsys.readouterr()
    answer = json.loads(told.out)
    assert answer["code"] == "bad_request"
    assert answer["message"] in told.err


def test_a_file_that_cannot_be_written_is_found_out_before_the_work(capsys: pytest.CaptureFixture[str]) -> None:
    problem = HOME / "domains/medicate/n5.yaml"
    assert main(["solve", str(problem), "-o", "/proc/plan.json", "--json"]) == 2
    told = capsys.readouterr()
    assert "/proc/plan.json:1:1: cannot be written" in told.err
    assert json.loads(told.out)["code"] == "bad_request"


@pytest.mark.parametrize(
    ("name", "said"),
    [("x" * 300, "is no file in a folder that exists"), ("a\0b", "an argument holds a null character")],
)
def test_a_name_that_no_file_can_have_is_no_output(
    name: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["solve", str(HOME / "domains/medicate/n5.yaml"), "-o", f"{name}/p.json"])
    assert said in capsys.readouterr().err


def test_python_m_kabo_is_kabo() -> None:
    run = subprocess.run(
        [sys.executable, "-m", "kabo", "--version"],
        capture_output=True,
        text=True,
        check=True,
        env=dict(os.environ),
    )
    assert run.stdout.startswith("kabo ")


# ------------------------------------------------------------------------------------------------ plans and domains
def test_a_plan_may_be_given_as_text() -> None:
    content = (CORPUS / "plan.json").read_bytes()
    assert plan_from_json(content.decode()) == plan_from_json(content)
    with pytest.raises(InputError, match="not JSON"):
        plan_from_json("\ud800")


def test_null_is_a_type_without_subtypes(tmp_path: Path) -> None:
    (tmp_path / "domain.yaml").write_text(
        "domain: d\ntypes: {a: null, b: null, c: ~}\npredicates: {p: [a], q: [b]}\nactions: {}\n"
    )
    assert not [finding for finding in check_files([tmp_path / "domain.yaml"]) if "twice" in finding.message]


# ------------------------------------------------------------------------------------------------ libraries in C++
def test_faces_that_stand_twice_and_turned_crash_nothing(tmp_path: Path) -> None:
    """CoACD ends with a segmentation fault on this box."""
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    faces = np.vstack([box.faces, np.array(box.faces)[:, ::-1]])
    made = enclosing_parts(Mesh(np.array(box.vertices), faces), 0.012, cache=tmp_path)
    while open_ones := [
        i for i in range(len(made.parts)) if not made.children_of(i) and made.deviation_of(i) > 0.012
    ]:
        assert made.finer is not None
        made = made.finer(open_ones[0])
    assert made.deviation <= 0.012


def test_faces_without_area_warn_of_nothing(tmp_path: Path) -> None:
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    vertices, faces = np.array(box.vertices), np.array(box.faces)
    a, b, c = faces[0]
    middle, new = (vertices[a] + vertices[b]) / 2, len(vertices)
    split = np.vstack([faces[1:], [[a, new, c], [new, b, c], [a, b, new]]])
    with np.errstate(all="raise"):
        assert len(enclosing_parts(Mesh(np.vstack([vertices, middle]), split), 0.004, cache=tmp_path).parts) == 1
