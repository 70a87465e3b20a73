"""What a scene cannot do, told in numbers before any search: overlaps at the start, regions and grippers too small."""
