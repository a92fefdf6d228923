"""Tools around the onboard model of an electromechanical actuator."""
