"""The array types that all rooms exchange: each name states the element type; shapes are given in docstrings."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]
