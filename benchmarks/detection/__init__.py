"""How often each verdict is given as CSJ and BLK grow, and whether the smallest shifts that are computed are those that are found, on records of the truth plant."""
