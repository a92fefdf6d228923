"""The truth plant: an independent float64 simulator whose records stand in for a machine.

Other integrator (Heun at 10 us), other friction (Coulomb located by bisection, or LuGre), own equations, sensor errors,
scatter from run to run. It shares no equation's code with the reference model or the C module.
"""

from benchmarks.truth.plant import Sensors, scattered, simulate_truth

__all__ = ["Sensors", "scattered", "simulate_truth"]
