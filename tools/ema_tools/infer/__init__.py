"""From fitted sets of causes to probabilities: priors in one table, the evidence of each set, and one decision."""
