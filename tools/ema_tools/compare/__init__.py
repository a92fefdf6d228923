"""Measured against simulated: whether a record can answer, where the model fails, what the rest depends on."""
