"""Settings of the annealer by a space-filling design: which reach the lowest point, which do not, and which of those are warned of."""
