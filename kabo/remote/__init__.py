"""The remote room: a robot of another process, driven over zenoh by messages, with heartbeats both ways.

`RobotServer` serves any `Robot` of the execution room, `ZenohRobot` is one. A motion is sent whole before it begins; if
the connection is lost, the server stops along the path, and the executor ends with the reason.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
