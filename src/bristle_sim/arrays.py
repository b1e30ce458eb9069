"""Types that annotations share."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""An array of floats; docstrings give its shape and unit."""

Number = Any
"""A float where the arguments are, else an array of their broadcast shape."""
