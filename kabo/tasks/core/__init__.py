"""Task Construction without robots: stages, containers, states, solutions, costs and their scheduling [T ch. 3].

Scenes are opaque here, and nothing of kabo is imported: any program may plan with these stages.
"""

from kabo.tasks.core.model.containers import (
    Alternatives,
    Container,
    Fallbacks,
    Limit,
    Merger,
    Parallel,
    Serial,
    Wrapper,
    fails_given,
)
from kabo.tasks.core.model.costs import constant, offset, total, uniform_random, weighted
from kabo.tasks.core.model.custom import backward, connector, forward, generator, monitor, propagator, wrapper
from kabo.tasks.core.model.errors import InitialisationError, TaskError, UndeclaredProperty, UndefinedProperty
from kabo.tasks.core.model.flow import Flow
from kabo.tasks.core.model.interfaces import arrows, directions, shown, tree
from kabo.tasks.core.model.properties import INTERFACE, MISSING, PARENT, Interface, Parent, Property, Reference
from kabo.tasks.core.model.results import SAME, Agreed, Failure, Result
from kabo.tasks.core.model.solutions import Solution, State
from kabo.tasks.core.model.stages import Connector, CostTerm, Generator, Misfit, Monitor, Propagator, Stage
from kabo.tasks.core.run.explanation import Explanation
from kabo.tasks.core.run.nodes import StageStatistics
from kabo.tasks.core.task import Task

__all__ = [
    "Agreed",
    "Alternatives",
    "Connector",
    "Container",
    "CostTerm",
    "Explanation",
    "Failure",
    "Fallbacks",
    "Flow",
    "Generator",
    "INTERFACE",
    "InitialisationError",
    "Interface",
    "Limit",
    "MISSING",
    "Merger",
    "Misfit",
    "Monitor",
    "PARENT",
    "Parallel",
    "Parent",
    "Propagator",
    "Property",
    "Reference",
    "Result",
    "SAME",
    "Serial",
    "Solution",
    "Stage",
    "StageStatistics",
    "State",
    "Task",
    "TaskError",
    "UndeclaredProperty",
    "UndefinedProperty",
    "Wrapper",
    "arrows",
    "backward",
    "connector",
    "constant",
    "directions",
    "fails_given",
    "forward",
    "generator",
    "monitor",
    "offset",
    "propagator",
    "shown",
    "total",
    "tree",
    "uniform_random",
    "weighted",
    "wrapper",
]
