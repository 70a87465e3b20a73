"""What robot stages share: paths of arms, motion constraints, targets, costs of motion."""
