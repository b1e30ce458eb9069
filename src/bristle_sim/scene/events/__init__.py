"""Events: the functions whose change of sign is one, and where within an interval that is."""
