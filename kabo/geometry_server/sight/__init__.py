"""What a camera sees of an object: sight lines that are proven free, ranges, angles, and viewpoints."""
