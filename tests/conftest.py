"""What all tests share: how hypothesis draws, and how much of the long property runs is run.

`KABO_PROPERTY_SCALE` (default 0.1) scales the number of examples; 1.0 is the whole run. Draws are derandomized,
so that a red run is red again.
"""

import os

from hypothesis import HealthCheck, settings

PROPERTY_SCALE = float(os.environ.get("KABO_PROPERTY_SCALE", "0.1"))

settings.register_profile(
    "kabo",
    max_examples=max(20, round(1000 * PROPERTY_SCALE)),
    derandomize=True,
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("kabo")
