from kabo.up.engine import KaboEngine as KaboEngine
from kabo.up.plans import plan_from_up as plan_from_up
from kabo.up.plans import plan_to_up as plan_to_up
from kabo.up.problems import Translation as Translation
from kabo.up.problems import problem_from_up as problem_from_up
from kabo.up.registration import register as register
