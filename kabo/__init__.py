"""kabo: combined task and motion planning on the knowledge level, with bounded geometric predicates.

The façade: `load_problem`, `solve`, `explain`, `verify`, `load_scene`, `GeometryServer`, `load_mesh`, `bounding_mesh`,
`bounding_decomposition` and the types of their arguments and results. The module imports nothing by itself: each
name imports its package when it is first used, so that `import kabo` takes milliseconds.
"""

import logging

from kabo.lazy import lazy_names

logging.getLogger(__name__).addHandler(logging.NullHandler())  # who uses kabo decides what comes of its messages
__getattr__, __dir__ = lazy_names(__name__, __file__, rooms=("explain", "verify"))
__version__ = "0.1.0"
