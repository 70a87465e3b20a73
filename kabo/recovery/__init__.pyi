from kabo.recovery.replanning import Replanner as Replanner
from kabo.recovery.undoing import undoing_plan as undoing_plan
