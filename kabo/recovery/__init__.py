"""The recovery room: how a run goes on after a surprise, by plans that are proven from where everything is observed to be.

First the robots go back to where the node began, if it has begun to change something; then the rest of the plan is tried
with the observed poses, and after that other actions. Each motion is verified before it is carried out.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
