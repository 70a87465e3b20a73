"""Ways: collision-free joint paths from one configuration to another, searched for and shortened.

Callers pass a function that tests whether segments are free, and a key that determines all random numbers; the
package does not depend on robots, meshes or goals.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
