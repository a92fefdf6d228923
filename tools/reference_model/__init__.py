"""The float64 reference model, written from the equations of docs/DESIGN.md and independent of the C module.

One module per block, one module per effect (found by name in `effects`), a solver at a hundredth of the model step with
located events, the commands and the random numbers.
"""

from reference_model.model import Recording, defaults, simulate

__all__ = ["Recording", "defaults", "simulate"]
