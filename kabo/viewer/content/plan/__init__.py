"""What a page shows of a plan: its graph laid out, motions, margins, swept volumes, knowledge, proofs, and faults."""
