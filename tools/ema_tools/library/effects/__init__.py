"""What is known of single effects: one module per row of `ema_effects.def`, found by its name, each with its `EFFECT`."""
