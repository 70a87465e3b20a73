"""Certificates about parts of which the verifier has seen already that they enclose the bodies.

To see that takes longer than to check a motion, and robots stand and wait. Each certificate has parts of its own, drawn as
tightly as its motions need; those of the plan that is being carried out suffice for most motions that come after it.
"""

from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.plan import Certificate, Plan
from kabo.planner.certify.certifying import certify


def certificate_with_parts(plan: Plan, surroundings: SceneSurroundings, earlier: Plan) -> Certificate | None:
    """A certificate about the parts of an earlier plan's certificate; None if these do not suffice, or there are none.

    Args:
        plan: the plan, with what grants its contacts. surroundings: the scene in which it begins.
        earlier: a plan that was verified.
    """
    if earlier.certificate is None:
        return None
    try:
        made = certify(plan, surroundings, parts=earlier.certificate.bodies)
    except ValueError:
        return None
    return made if isinstance(made, Certificate) else None
