"""What the user brings: actuator files, recordings, commands, and the measured or shipped ones among them."""
