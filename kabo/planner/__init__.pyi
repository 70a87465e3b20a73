from kabo.planner.result import Progress as Progress
from kabo.planner.result import Reason as Reason
from kabo.planner.result import Result as Result
from kabo.planner.result import diagnostic_to_json as diagnostic_to_json
from kabo.planner.result import invalid_to_json as invalid_to_json
from kabo.planner.result import result_to_json as result_to_json
