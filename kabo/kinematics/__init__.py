"""Kinematics: constraints between features, configurations that fulfil them, straight lines of the tool.

A constraint becomes flat scalar rows (`rows_of`), rows are sampled and projected onto by one kernel (`sample`,
`project`), and a motion is proven to fulfil them throughout (`keeps`). The configurations that reach a pose are
the pose's `solutions`, in closed form where the axes allow it. The package works with trees of joints only,
without obstacles or goals.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
