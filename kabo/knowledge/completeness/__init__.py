"""Whether knowledge is complete for a problem: only then is a search that tried everything a proof."""
