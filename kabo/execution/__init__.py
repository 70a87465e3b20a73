"""The execution room: a plan is walked, its trajectories are followed, and what happens is watched and logged.

A robot and its sensors are protocols of a few methods (`Robot`, `Sensor`); a kinematic robot is here, a simulated one in
`kabo.simulation`.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
