"""Other solutions of the tasks of a stretch, where they make the plan's way shorter: dynamic programming along it.

Tasks can be asked for their next solution: another grasp, another place, another branch of inverse kinematics. Along a
stretch the shortest way to each state is kept for the few best states. An end that is a new one has to pay for what
follows: nodes behind it keep their motion where that is still proven and what it moves is where it was; the others are
asked anew, and the sum over the whole plan decides.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from kabo.geometry_server.answers import Success
from kabo.geometry_server.situation import Situation
from kabo.planner.refining_stops import Stop
from kabo.tasks.robots.joining import segment_length
from kabo.tasks.robots.legs import proven

if TYPE_CHECKING:
    from kabo.tasks.procedures import GeometricProcedures

SOLUTIONS, BEAM = 4, 4  # of each task; of states that are kept
ENDS, AGAIN = 2, 1  # of a stretch that are followed; solutions of what follows
