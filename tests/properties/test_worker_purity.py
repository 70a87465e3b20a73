"""A worker is a function of the request's bytes: whatever it answered before, it answers as a fresh process would."""

import json
import random
from base64 import b64decode
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from kabo.arrays import Array
from kabo.geometry.bounding.shapes import shape_of
from kabo.geometry.bounding.stored_parts import Cover, write
from kabo.meshes import load_mesh
from kabo.service import pack_problem
from tests.conftest import PROPERTY_SCALE
from tests.service.lives import Asked, Files, Nursery

DOMAINS = Path(__file__).parents[2] / "domains"
PAIRS = 120 if PROPERTY_SCALE >= 1.0 else 7
QUICK = 6
SYMBOLIC = ("doors/n3", "wumpus/n4", "unix/n1", "medicate/n5", "safes/n3", "bomb_in_the_toilet/n3", "logistics/n3")
STACKED = "domains/stacked"
BLOCK = "meshes/block/block.stl"
TRIANGLE = np.dtype([("corners", "<f4", (4, 3)), ("attributes", "<u2")])  # of binary STL, the normal first

Change = Callable[[dict[str, bytes], random.Random], None]


def replaced(name: str, old: str, *new: str) -> Change:
    """A change of a text file that puts one of `new` for the first `old`."""

    def change(files: dict[str, bytes], draw: random.Random) -> None:
        assert old.encode() in files[name], (name, old)
        files[name] = files[name].replace(old.encode(), draw.choice(new).encode(), 1)

    return change


def box(size: float) -> tuple[Array, NDArray[np.int64]]:
    """The corners and triangles of a cube about the origin."""
    corners = size * (np.array([[i >> 2 & 1, i >> 1 & 1, i & 1] for i in range(8)]) - 0.5)
    sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return corners, np.array([[a, *pair] for a, b, c, d in sides for pair in ((b, c), (c, d))])


def stl(size: float) -> bytes:
    """A cube as binary STL; cubes of all sizes have as many bytes."""
    corners, faces = box(size)
    triangles = np.zeros(len(faces), TRIANGLE)
    triangles["corners"][:, 1:] = corners[faces]
    return bytes(80) + len(faces).to_bytes(4, "little") + triangles.tobytes()


def other_mesh(files: dict[str, bytes], draw: random.Random) -> None:
    """The block a little smaller, in a file of the same size."""
    files[BLOCK] = stl(draw.choice((0.039, 0.0395, 0.0398)))


def other_parts(files: dict[str, bytes], draw: random.Random) -> None:
    """Convex parts beside the block that are 0.5 mm or less too large, as they may be; or none that can be read."""
    mesh, written = Path("block.stl"), Path("block.parts")
    mesh.write_bytes(files[BLOCK])
    read = load_mesh(mesh)
    grown = read.vertices * (1 + draw.choice((0.005, 0.01, 0.02)))
    shape = shape_of(read)
    part = (grown - shape.origin) / shape.scale
    tolerance = shape.lengths(0.001)
    write(written, shape.digest, [Cover((part,), (tolerance,), tolerance)])
    files[f"{BLOCK}.parts"] = written.read_bytes() if draw.random() < 0.8 else b"none"


CHANGES: tuple[Change, ...] = (
    other_mesh,
    other_parts,
    replaced(f"{STACKED}/tasks/restack.yaml", "name: reach", "name: spans", "name: gangs"),
    replaced(f"{STACKED}/tasks/restack.yaml", "max_solutions: 8", "max_solutions: 1", "max_solutions: 3"),
    replaced(f"{STACKED}/tasks/restack.yaml", "goal: open", "goal: ajar", "goal: [1]"),
    replaced(
        f"{STACKED}/scene.yaml", "distance: [0.05, 0.08]", "distance: [0.03, 0.06]", "distance: [0.06, 0.07]"
    ),
    replaced(f"{STACKED}/scene.yaml", "epsilon: 0.01", "epsilon: 0.02", "epsilon: 0.03"),
    replaced(f"{STACKED}/scene.yaml", "-20 deg", "-10 deg", "-15 deg"),
    replaced(f"{STACKED}/scene.yaml", "robots:", "robot_:"),
    replaced(f"{STACKED}/domain.yaml", "  move:", "  haul:", "  lift:"),
    replaced(f"{STACKED}/domain.yaml", "K(highest(this))", "K(highest(that))"),
    replaced(f"{STACKED}/n2.yaml", "one_below(o2) = o1)", "one_below(o2) = stack_3)", "one_below(o2) = stack_2)"),
    replaced(f"{STACKED}/n2.yaml", "[0, 0, 0.025]", "[0, 0, 0.026]", "[0.01, 0, 0.025]"),
    replaced("meshes/mobile5/mobile5.urdf", 'upper="', 'upper="0', 'upper="1'),
    replaced("meshes/mobile5/mobile5.urdf", "<robot", "<rob0t"),
)


@pytest.fixture(scope="module")
def nursery(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Nursery]:
    made = Nursery(tmp_path_factory.mktemp("root"))
    yield made
    made.close()


@pytest.fixture(autouse=True)
def _somewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def files_of(problem: str) -> tuple[str, dict[str, bytes]]:
    """A problem's path and files, as a client packs them."""
    packed = pack_problem(DOMAINS / f"{problem}.yaml")
    return packed["path"], {
        name: held.encode() if isinstance(held, str) else b64decode(held["base64"])
        for name, held in packed["files"].items()
    }


def blocks() -> tuple[str, dict[str, bytes]]:
    """Two blocks, which are cubes without parts beside their mesh."""
    path, files = files_of("stacked/n2")
    return path, {**files, BLOCK: stl(0.04), f"{BLOCK}.parts": b"none"}


def geometric(draw: random.Random) -> tuple[str, Files]:
    """The small problem of blocks with up to three changes."""
    path, files = blocks()
    often = draw.sample(CHANGES[:2], draw.randint(0, 1))
    for change in (*often, *draw.sample(CHANGES[2:], draw.randint(0, 2))):
        change(files, draw)
    return path, files


def symbolic(draw: random.Random) -> tuple[str, Files]:
    """A problem and its domain, whichever they are, in files of the same names."""
    path, files = files_of(draw.choice(SYMBOLIC))
    return "problem.yaml", {
        "problem.yaml" if name == path else "domain.yaml": data for name, data in files.items()
    }


@pytest.mark.parametrize(
    "seed", [pytest.param(n, marks=[pytest.mark.slow] if n >= QUICK else []) for n in range(PAIRS)]
)
def test_two_requests_of_equal_names_do_not_meet(nursery: Nursery, seed: int) -> None:
    draw = random.Random(seed)
    make = geometric if seed % 3 else symbolic
    rooted = draw.random() < 0.5
    first, second = (Asked(files, path, rooted) for path, files in (make(draw), make(draw)))
    one, other = nursery.life([first, second, first]), nursery.life([second, first])
    fresh = one[0], other[0]  # the first answer of each life
    assert one == [fresh[0], fresh[1], fresh[0]]
    assert other == [fresh[1], fresh[0]]


@pytest.mark.parametrize("change", CHANGES[:4])
def test_the_changes_are_seen_at_all(nursery: Nursery, change: Change) -> None:
    """Were they not, nothing would be tested: a changed file gives another plan, or another finding."""
    path, files = blocks()
    changed = dict(files)
    change(changed, random.Random(0))
    assert nursery.life([Asked(files, path)]) != nursery.life([Asked(changed, path)])


@pytest.mark.parametrize("change", CHANGES[:3])
def test_an_edited_file_below_the_root_is_seen(nursery: Nursery, change: Change) -> None:
    """A mesh, the parts beside it and a task file, of the same size and date as before."""
    path, files = blocks()
    edited = dict(files)
    change(edited, random.Random(1))
    (fresh,) = nursery.life([Asked(edited, path, rooted=True)])
    before, after, again = nursery.life([Asked(each, path, rooted=True) for each in (files, edited, files)])
    assert json.loads(before[0])["status"] == json.loads(after[0])["status"] == "solved"
    assert before == again and before != after == fresh
