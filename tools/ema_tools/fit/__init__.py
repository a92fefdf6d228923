"""Noise, nuisance parameters, evidence, and the fit of effects to it."""
