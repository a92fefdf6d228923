"""The onboard annealer beside other searches, all on the flight's own objective."""
