"""The table of all robot stages by their names in task files; importing it loads every stage and its kernels."""

from kabo.lazy import names_of
from kabo.tasks.core import Stage
from kabo.tasks.robots import stages

STAGES: dict[str, type[Stage]] = {name: getattr(stages, name) for name in names_of(stages)}
