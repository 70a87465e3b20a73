"""What is committed under meshes/ is what scripts/ makes, and every mesh is a solid."""

from pathlib import Path

import numpy as np
import pinocchio
import pytest
import trimesh

from kabo.geometry.triangles.crossings import crossing_faces
from scripts.generate_meshes import GEARBOX, MESHES, ROBOTS, THINGS, generate
from scripts.mesh_files import triangles
from scripts.solids import HIGH, LOW, Detail

STL_FILES = sorted(path.relative_to(MESHES).as_posix() for path in MESHES.glob("*/*.stl"))
VOLUMES = {  # m³ of the ideal shape, or of a plain body that it differs little from
    "block/block.stl": (0.04**3 * 0.98, 0.04**3),
    "table/table.stl": (0.5 * 0.85 * 0.03, 0.5 * 0.85 * 0.03 + 4 * np.pi * 0.025**2 * 0.38),
    "crate/crate.stl": (0.36**2 * 0.05 - 0.34**2 * 0.04 - 1e-4, 0.36**2 * 0.05 - 0.34**2 * 0.04 + 1e-4),
    "cup/cup.stl": (0.8 * 2 * np.pi * 0.032 * 0.004 * 0.1, 1.4 * 2 * np.pi * 0.032 * 0.004 * 0.1),
    "bottle/bottle.stl": (1e9 * np.pi * 0.03**2 * 0.15, 1e9 * np.pi * 0.03**2 * 0.24),  # mm³
}


@pytest.fixture(scope="module")
def regenerated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("meshes")
    generate(folder, HIGH)
    return folder


def test_regenerating_gives_the_committed_files_byte_for_byte(regenerated: Path) -> None:
    made = sorted(path.relative_to(regenerated).as_posix() for path in regenerated.rglob("*") if path.is_file())
    kept = sorted(
        path.relative_to(MESHES).as_posix() for path in MESHES.rglob("*") if path.suffix in {".stl", ".urdf"}
    )
    assert made == kept
    different = [name for name in made if (regenerated / name).read_bytes() != (MESHES / name).read_bytes()]
    assert not different, f"run python -m scripts.generate_meshes; these differ: {different}"


@pytest.mark.parametrize("name", STL_FILES)
def test_every_mesh_is_one_closed_solid_with_its_normals_outside(name: str) -> None:
    mesh = trimesh.load(MESHES / name)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.body_count == 1
    assert mesh.volume > 0.0
    assert not np.any(mesh.area_faces == 0.0)


@pytest.mark.parametrize("detail", [LOW, HIGH], ids=["low", "high"])
@pytest.mark.parametrize("name", sorted(GEARBOX))
def test_no_part_of_the_gearbox_crosses_itself(name: str, detail: Detail) -> None:
    assert not crossing_faces(*triangles(GEARBOX[name](detail))).any()


@pytest.mark.parametrize("name", sorted(VOLUMES))
def test_volumes_are_those_of_the_shapes(name: str) -> None:
    least, most = VOLUMES[name]
    assert least < trimesh.load(MESHES / name).volume < most


def test_the_six_axis_arm_has_forty_thousand_triangles() -> None:
    assert sum(len(trimesh.load(path).faces) for path in (MESHES / "arm6").glob("*.stl")) >= 40_000


def test_low_detail_comes_from_the_same_parameters_with_a_fifth_of_the_triangles(tmp_path: Path) -> None:
    low = generate(tmp_path, LOW)
    for name, count in low.items():
        coarse, fine = trimesh.load(tmp_path / name), trimesh.load(MESHES / name)
        assert coarse.is_watertight
        if len(fine.faces) > 100:  # a box is a box at any detail
            assert count < 0.3 * len(fine.faces)
        size = np.linalg.norm(fine.extents)
        assert np.abs(coarse.bounds - fine.bounds).max() < 0.02 * size, name


@pytest.mark.parametrize("name", sorted(ROBOTS))
def test_every_robot_loads_in_pinocchio_with_a_mesh_for_each_link_that_has_a_body(name: str) -> None:
    urdf = MESHES / name / f"{name}.urdf"
    model = pinocchio.buildModelFromUrdf(str(urdf))
    geometry = pinocchio.buildGeomFromUrdf(model, str(urdf), pinocchio.COLLISION, package_dirs=[str(urdf.parent)])
    assert len(geometry.geometryObjects) == len(list(urdf.parent.glob("*.stl")))
    assert (model.velocityLimit > 0.0).all()
    assert (model.lowerPositionLimit < model.upperPositionLimit).all()


@pytest.mark.parametrize(
    ("name", "tool", "reach"), [("arm6", "tool0", (0.05, 0.05, 1.428)), ("arm7", "tool0", (0.0, 0.0, 1.306))]
)
def test_at_zero_the_arms_stand_up_to_their_published_height(
    name: str, tool: str, reach: tuple[float, ...]
) -> None:
    model = pinocchio.buildModelFromUrdf(str(MESHES / name / f"{name}.urdf"))
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, pinocchio.neutral(model))
    assert np.allclose(data.oMf[model.getFrameId(tool)].translation, reach)


def test_everything_generated_takes_at_most_25_megabytes() -> None:
    assert sum(path.stat().st_size for path in MESHES.rglob("*") if path.is_file()) <= 25e6


def test_every_thing_has_a_mesh() -> None:
    assert all((MESHES / name / f"{name}.stl").is_file() for name in THINGS)
