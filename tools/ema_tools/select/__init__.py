"""Which effect is missing: candidates, their sensitivities, the search over sets of them, and its confirmation."""
