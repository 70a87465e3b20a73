"""What every procedure is given beside its arguments: the scene around, the seed, and how much to try."""

from dataclasses import dataclass

from kabo.geometry_server.workspace import Surroundings
from kabo.scene import Scene


@dataclass(frozen=True)
class Context:
    """The surroundings, the seed of all streams, and how many batches of candidates and path samples to try."""

    surroundings: Surroundings
    seed: int
    batches: int
    path_samples: int

    @property
    def scene(self) -> Scene:
        """The scene."""
        return self.surroundings.scene
