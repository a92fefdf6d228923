"""Tools around the onboard model of an electromechanical actuator."""

__version__ = "0.1.0"
