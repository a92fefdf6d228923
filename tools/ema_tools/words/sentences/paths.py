"""Commands inside of sentences, with the files that were given in the place of the general words."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence


def with_paths(text: str, actuator: str, records: Sequence[str], healthy: Sequence[str] = ()) -> str:
    """The text with ACTUATOR, REC and `--healthy REC ...` as they were given, ready to be copied; without healthy records that option stays as it is."""
    named = {"ACTUATOR": shlex.quote(actuator), "REC": shlex.join(records)}
    runs = f"--healthy {shlex.join(healthy)}" if healthy else "--healthy REC ..."
    parts = text.split("--healthy REC ...")
    return runs.join(re.sub(r"\b(ACTUATOR|REC)\b(?=[^\w.]|$)", lambda found: named[found.group(1)], part) for part in parts)
