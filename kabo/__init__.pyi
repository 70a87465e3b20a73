from kabo.errors import Diagnostic as Diagnostic
from kabo.errors import InputError as InputError
from kabo.errors import KaboError as KaboError
from kabo.errors import ServiceError as ServiceError
from kabo.explain.explain import Explanation as Explanation
from kabo.explain.explain import explain as explain
from kabo.geometry import bounding_decomposition as bounding_decomposition
from kabo.geometry import bounding_mesh as bounding_mesh
from kabo.geometry_server import GeometryServer as GeometryServer
from kabo.language import load_problem as load_problem
from kabo.language.problem import Problem as Problem
from kabo.meshes import load_mesh as load_mesh
from kabo.plan import Plan as Plan
from kabo.plan import plan_from_json as plan_from_json
from kabo.plan import plan_to_json as plan_to_json
from kabo.plan import policy as policy
from kabo.plan import unfold as unfold
from kabo.planner.result import Progress as Progress
from kabo.planner.result import Reason as Reason
from kabo.planner.result import Result as Result
from kabo.planner.solve import solve as solve
from kabo.scene import Scene as Scene
from kabo.scene import load_scene as load_scene
from kabo.verify import verify_plan as verify_plan
from kabo.verify.verification import verify as verify

__version__: str
