"""Which physical effect is missing from a model: evidence, candidates, and the search over sets of effects."""
