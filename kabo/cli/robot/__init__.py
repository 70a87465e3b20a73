"""`kabo robot`: makes the entry of a robot for scenes from its URDF."""

from kabo.cli.robot.making import HELP, NAME, add_arguments, run

__all__ = ["HELP", "NAME", "add_arguments", "run"]
