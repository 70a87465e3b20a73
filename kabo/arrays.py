"""The array types that all rooms exchange: a name says the type of the elements, docstrings say the shape."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
