"""What robot stages share: ways and strokes of arms, motion constraints, targets, costs of motion."""
