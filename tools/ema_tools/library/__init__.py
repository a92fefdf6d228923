"""What exists: parameters, effects, fault parameters, and the facts and words about each."""
