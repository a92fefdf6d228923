"""`python -m ema_tools`."""

from ema_tools.cli import main

main()
