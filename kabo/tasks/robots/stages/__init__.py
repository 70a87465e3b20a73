"""The stages of robots, one phase of a manipulation each: grasps, placements, motions, filters."""
