"""The local page of `ema watch`: what it shows as data, the page itself, and the server that hands both to this machine alone."""
