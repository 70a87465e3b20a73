"""Other planning languages: PDDL, contingent PDDL and PKS XML, read into the one kind of problem that kabo plans for."""
