"""The original's triangles on the faces of a contracted mesh: each is there as a whole, as near as its bounds say."""

import importlib
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pytest
import trimesh

from kabo.geometry.bounding import contraction_state as state
from kabo.geometry.bounding.kernels import carried_triangles as kernels
from kabo.meshes import Mesh
from tests.geometry.surfaces import distances_to_surface

room = importlib.import_module("kabo.geometry.bounding.bounding_mesh")
FINE = np.array([(i, j, 8 - i - j) for i in range(9) for j in range(9 - i)]) / 8.0


def ball():
    made = trimesh.creation.icosphere(subdivisions=2)
    return Mesh(np.array(made.vertices), np.array(made.faces, np.int64))


def plate():
    made = trimesh.creation.box(extents=(1.0, 0.7, 0.02)).subdivide().subdivide()
    return Mesh(np.array(made.vertices), np.array(made.faces, np.int64))


def cone():
    made = trimesh.creation.cone(radius=0.7, height=1.0, sections=50)
    return Mesh(np.array(made.vertices), np.array(made.faces, np.int64))


MESHES = {"ball": ball, "plate": plate, "cone": cone}


@dataclass
class Seen:
    """The arrays at the end of the contractions of a bounding mesh."""

    net: Any
    carried: Any
    tree: Any
    made: Any

    @property
    def alive(self):
        return np.flatnonzero(self.net.faces[:, 0] >= 0)

    def nodes(self, f):
        found, n = [], int(self.carried.heads[f])
        while n >= 0:
            found.append(n)
            n = int(self.carried.following[n])
        return found


@pytest.fixture(params=[(name, side) for name in MESHES for side in ("outer", "inner")], ids="-".join)
def seen(request, monkeypatch):
    name, side = request.param
    kept = {}

    def keeping(name, make, *arguments):
        kept[name] = make(*arguments)
        return kept[name]

    for module, name_of_maker in ((state, "net_of"), (state, "carried_of"), (room, "tree_of")):
        make = partial(keeping, name_of_maker, getattr(module, name_of_maker))
        monkeypatch.setattr(module, name_of_maker, make)
    made = room.bounding_mesh(MESHES[name](), 0.06, side)
    assert made.contractions > 30
    return Seen(kept["net_of"], kept["carried_of"], kept["tree_of"], made)


def test_every_point_of_the_original_is_within_the_bound_of_a_part_of_its_triangle(seen):
    carried, vertices, faces = seen.carried, seen.net.vertices, seen.net.faces
    parts = {t: [] for t in range(len(seen.tree.triangles))}
    for f in seen.alive:
        for n in seen.nodes(f):
            t = int(carried.items[n])
            if carried.stamps[n] == carried.valid[t]:
                parts[t].append((f, carried.bounds[n]))
    assert all(parts.values())
    for t, where in list(parts.items())[::5]:
        points = FINE @ seen.tree.triangles[t]
        reached = np.array([distances_to_surface(points, vertices, faces[[f]]) - bound for f, bound in where])
        assert reached.min(axis=0).max() <= 1e-12
        assert max(bound for _, bound in where) <= seen.made.epsilon


def test_every_point_of_a_face_is_within_its_bound_of_the_original(seen):
    corners = seen.tree.triangles.reshape(-1, 3)
    numbers = np.arange(len(corners)).reshape(-1, 3)
    for f in seen.alive[:: max(1, len(seen.alive) // 40)]:
        points = FINE @ seen.net.vertices[seen.net.faces[f]]
        assert distances_to_surface(points, corners, numbers).max() <= seen.net.errors[f] + 1e-12
        assert seen.net.errors[f] <= seen.made.epsilon


def test_every_node_is_on_one_face_or_free(seen):
    carried = seen.carried
    used = [n for f in range(len(carried.heads)) for n in seen.nodes(f)]
    free, n = [], int(carried.free[0])
    while n >= 0:
        free.append(n)
        n = int(carried.following[n])
    assert len(free) == carried.free[1]
    assert sorted(used + free) == list(range(len(carried.items)))
    dead = np.flatnonzero(seen.net.faces[:, 0] < 0)
    assert (carried.heads[dead] == -1).all()


def fresh(faces=6, nodes=20, start=kernels.start):
    carried = state.carried_of(faces, nodes)
    start(carried, np.arange(faces)[::-1].copy())
    return carried


def on(carried, f):
    found, n = [], int(carried.heads[f])
    while n >= 0:
        found.append(n)
        n = int(carried.following[n])
    return found


@pytest.mark.parametrize("nodes", [6, 7, 20])
def test_at_the_beginning_each_face_has_the_triangle_that_it_is(nodes):
    carried = fresh(nodes=nodes)
    assert [[int(carried.items[n]) for n in on(carried, f)] for f in range(6)] == [[5], [4], [3], [2], [1], [0]]
    assert carried.free[1] == nodes - 6
    assert carried.bounds[:6].tolist() == [0.0] * 6


def test_stale_nodes_are_dropped_and_others_stay():
    carried = fresh(nodes=7)
    carried.valid[[1, 3]] += 1
    if len(carried.free) > 2:
        carried.free[2] = 100  # below which stale ones are looked for
    kernels.drop_stale(carried)
    assert [len(on(carried, f)) for f in range(6)] == [1, 1, 0, 1, 0, 1]
    assert carried.free[1] == 3


def test_compiled_and_original_start_alike():
    for one, two in zip(fresh(), fresh(start=kernels.start.py_func), strict=True):
        length = 6 if one.dtype == float else len(one)
        assert np.array_equal(one[:length], two[:length])
