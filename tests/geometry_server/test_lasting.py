"""What is known of a loaded scene whatever the seed: who loads the same scene finds it, and nobody else."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from kabo.geometry_server import GeometryServer
from kabo.geometry_server.checked_pairs import first_along
from kabo.language import load_problem
from kabo.scene import Scene, load_scene
from tests.geometry_server.conftest import DOMAINS


@pytest.fixture
def scene() -> Scene:
    description = load_problem(DOMAINS / "stacked/n2.yaml").scene
    assert description is not None
    return load_scene(description)


def found(server: GeometryServer, made: object) -> object:
    return server.surroundings.lasting(("fact",), lambda: made)


def test_servers_of_one_scene_find_what_others_made_whatever_their_seed_and_state(scene: Scene) -> None:
    assert found(GeometryServer(scene), 1) == 1
    assert found(GeometryServer(scene, seed=7), 2) == 1
    assert found(GeometryServer(replace(scene, start=scene.start, met=True)), 2) == 1


def test_what_other_distances_or_bodies_determine_is_made_anew(scene: Scene) -> None:
    assert found(GeometryServer(scene), 1) == 1
    name = next(iter(scene.bodies))
    others = [
        GeometryServer(scene, epsilon=0.5 * scene.epsilon),
        GeometryServer(scene, clearance=0.01),
        GeometryServer(replace(scene, uncertain={name: 0.005})),
        GeometryServer(replace(scene, allowed=frozenset([frozenset(("a", "b"))]))),
        GeometryServer(replace(scene, bodies=dict(scene.bodies))),
    ]
    assert [found(server, 2 + i) for i, server in enumerate(others)] == [2, 3, 4, 5, 6]


def test_threads_have_arrays_of_their_own(scene: Scene) -> None:
    """A view writes into them while it checks."""
    own = GeometryServer(scene).surroundings._lasting
    with ThreadPoolExecutor(1) as pool:
        other = pool.submit(lambda: own.bodies).result()
    assert own.bodies is own.bodies and other is not own.bodies


@pytest.mark.parametrize(("by_one", "asked"), [(True, [1, 1]), (False, [4])])
def test_the_first_segment_that_is_not_free_is_named(by_one: bool, asked: list[int]) -> None:
    calls: list[int] = []

    def segments_hit(starts: np.ndarray, ends: np.ndarray, strays: np.ndarray) -> np.ndarray:
        calls.append(len(starts))
        return np.where(starts[:, 0] == 0.0, -1, starts[:, 0]).astype(np.int64)

    path = np.array([[0.0], [5.0], [6.0], [0.0], [7.0]])
    assert first_along(segments_hit, path, None, by_one=by_one) == 5 and calls == asked
    assert first_along(segments_hit, path[:1], None, by_one=by_one) == -1
