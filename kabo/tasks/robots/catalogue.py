"""Every robot stage by its name in task files; importing this file loads them all, and their kernels."""

from kabo.lazy import names_of
from kabo.tasks.core import Stage
from kabo.tasks.robots import stages

STAGES: dict[str, type[Stage]] = {name: getattr(stages, name) for name in names_of(stages)}
