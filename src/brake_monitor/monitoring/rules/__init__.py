"""One file per rule, named after its alarm, and what several rules share."""
