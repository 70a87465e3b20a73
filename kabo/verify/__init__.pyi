from kabo.verify.certificate.clearance import FAR as FAR
from kabo.verify.knowledge import validate_worlds as validate_worlds
from kabo.verify.report import Finding as Finding
from kabo.verify.report import Least as Least
from kabo.verify.report import Report as Report
from kabo.verify.report import WorldReport as WorldReport
from kabo.verify.verification import verify_plan as verify_plan
