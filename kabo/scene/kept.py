"""Scenes that were loaded before in this process, for whoever loads the same one again and again."""

from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Any

from kabo.children import never
from kabo.language.scene_description import SceneDescription
from kabo.scene.scene import Scene, hashes, load_scene

MOST_REMEMBERED = 100_000  # some hundred bytes each
MOST = 4  # scenes; meshes of a large one take some hundred megabytes


class KeptScenes:
    """The scenes loaded last, each by its description; a scene of which a file has changed since is loaded anew.

    What was done with a scene may be noted, so that it is not done again; it goes when the scene goes.
    """

    def __init__(self) -> None:
        self._scenes: OrderedDict[int, tuple[SceneDescription, Scene, set[Hashable]]] = OrderedDict()

    def scene(
        self, description: SceneDescription, look: Callable[[], None] = never
    ) -> tuple[Scene, set[Hashable]]:
        """The scene of a description, and the notes on it, to which more may be added; as `load_scene` otherwise."""
        known = self._scenes.get(id(description))
        if known is not None and known[0] is description and _unchanged(known[1]):
            self._scenes.move_to_end(id(description))
            return known[1], known[2]
        scene, notes = load_scene(description, look), set[Hashable]()
        self._scenes[id(description)] = description, scene, notes
        while len(self._scenes) > MOST:
            self._scenes.popitem(last=False)
        return scene, notes


def _unchanged(scene: Scene) -> bool:
    """Whether all files of a scene have the content that was loaded."""
    try:
        return hashes([path for path in scene.files if path.suffix != ".parts"]) == dict(scene.files)
    except OSError:
        return False


def memory_of(scene: Scene, kind: Hashable) -> dict[bytes, Any]:
    """What is remembered of a kind, by all on which it depends but the loaded robots, which are those of the scene.

    It is emptied when it gets too large.
    """
    robots = tuple(scene.robots.values())
    if not robots:
        return {}
    known: dict[bytes, Any] = robots[0].memory.setdefault((kind, *map(id, robots)), {})
    if len(known) > MOST_REMEMBERED:
        known.clear()
    return known
