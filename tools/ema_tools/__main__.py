"""`python -m ema_tools`, and what the launcher `ema` runs."""

from ema_tools.base.interrupted import Interrupted, end_at_once, tidy_up, too_late

end_at_once()

import sys  # noqa: E402 - Ctrl-C has its answer before more is loaded

from ema_tools.cli import main  # noqa: E402
from ema_tools.words.terminal.console import complain  # noqa: E402

try:
    tidy_up()
    main()
except Interrupted:
    complain("interrupted")
    sys.exit(130)
finally:
    too_late()
