"""What accuracy costs, what the impact law costs, and whether the program stays stable where it is hard."""
