"""The gallery: what README files say of a plan, and their pictures, are what the commands make."""

from io import BytesIO
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from kabo.pictures import runs
from kabo.plan import load_plan
from scripts import picture_run, picture_simulations
from scripts.gallery import readme_of, renewed
from scripts.pictures import MOVING, NAMES, PROGRAMS, ROOT, SHOWN, SYMBOLIC, TABLE, drawn, plan_of
from tests.conftest import PROPERTY_SCALE

PICTURES = [
    path
    for folder in ("docs", "domains", "examples")
    for path in (ROOT / folder).rglob("*")
    if path.suffix in {".png", ".gif", ".svg"}
]
LARGEST = {".png": 300_000, ".svg": 300_000, ".gif": 2_000_000}  # bytes
ROWS = {row.picture: row for row in TABLE}
LIKE = 6.0  # of 255: mean difference of pixels that other versions of the graphics library may make


@pytest.fixture(scope="module")
def plans(tmp_path_factory):
    return tmp_path_factory.mktemp("plans")


def text_of(folder: str) -> str:
    readme = readme_of(folder)
    return "" if readme is None else readme.read_text()


def require_alike(name: str, plans: Path) -> None:
    """Checks that a picture has the size and the likeness of the one that is drawn now."""
    pytest.importorskip("pyvista")
    require_like(name, drawn(ROWS[name], plans))


def require_like(name: str, picture: bytes) -> None:
    """Checks that a picture, or the first frame of one that moves, is like that in the repository."""
    from PIL import Image

    new = np.asarray(Image.open(BytesIO(picture)).convert("RGB"), float)
    old = np.asarray(Image.open(ROOT / name).convert("RGB"), float)
    assert new.shape == old.shape and np.abs(new - old).mean() < LIKE, f"python -m scripts.pictures {name}"


def test_every_domain_shows_a_plan():
    assert {path.parent for path in (ROOT / "domains").glob("*/domain.yaml")} == {
        ROOT / folder for folder in SHOWN if folder.startswith("domains/")
    }


@pytest.mark.parametrize("path", PICTURES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_a_picture_is_of_moderate_size_and_made_by_a_command(path):
    name = path.relative_to(ROOT).as_posix()
    assert path.stat().st_size <= LARGEST[path.suffix]
    assert name in NAMES or name.rpartition("/")[0] in PROGRAMS


def test_every_picture_of_the_table_is_there():
    assert [name for name in NAMES if not (ROOT / name).exists()] == []


@pytest.mark.parametrize("folder", SYMBOLIC)
def test_a_readme_and_a_graph_are_what_the_commands_write(folder, plans):
    plan_file = plan_of(f"{folder}/{SHOWN[folder]}.yaml", plans)
    assert renewed(text_of(folder), folder, load_plan(plan_file)) == text_of(folder), "python -m scripts.gallery"
    assert drawn(ROWS[f"{folder}/plan.svg"], plans) == (ROOT / folder / "plan.svg").read_bytes()


def test_the_picture_of_a_scene_is_like_the_one_drawn_now(plans):
    require_alike("domains/assembly/scene.png", plans)


@pytest.mark.slow
@pytest.mark.parametrize("folder", MOVING)
def test_a_plan_with_motion_is_what_the_commands_write(folder, plans):
    plan_file = plan_of(f"{folder}/{SHOWN[folder]}.yaml", plans)
    text = text_of(folder)
    assert text == "" or renewed(text, folder, load_plan(plan_file)) == text, "python -m scripts.gallery"
    assert drawn(ROWS[f"{folder}/plan.svg"], plans) == (ROOT / folder / "plan.svg").read_bytes()
    require_alike(f"{folder}/plan.png", plans)


@pytest.mark.slow
@pytest.mark.parametrize("module", [picture_run, *([picture_simulations] if PROPERTY_SCALE >= 1.0 else [])])
def test_pictures_of_physics_are_like_those_drawn_now(module, monkeypatch):
    pytest.importorskip("pyvista")
    pytest.importorskip("mujoco")
    frames = runs._drawn
    monkeypatch.setattr(runs, "_drawn", lambda *arguments: islice(frames(*arguments), 2))  # one is compared
    name = next(name for name, program in PROGRAMS.items() if program == module.__name__)
    require_like(name, module.made())
