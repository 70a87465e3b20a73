"""From a problem to bits: schemas to instances, formulas to queries, effects to updates, what never changes settled."""
