from kabo.tasks.learned.learned_parameters import LearnedParameters as LearnedParameters
from kabo.tasks.learned.models import Model as Model
from kabo.tasks.learned.models import open_model as open_model
from kabo.tasks.learned.naming import MisfitError as MisfitError
from kabo.tasks.learned.records import learned_by as learned_by
from kabo.tasks.learned.records import learned_in as learned_in
from kabo.tasks.learned.risks import Risk as Risk
from kabo.tasks.learned.risks import risk as risk
