"""The simulation room: a scene as a model of physics, stepped by MuJoCo (extra `simulation`), and its robots and sensors.

The model is written as MJCF, by kabo alone; MuJoCo is loaded when something is stepped.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
