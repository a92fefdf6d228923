"""The numbers that steer the diagnosis, and what its answers owe to them.

    python -m benchmarks.constants                                # all of them with their reasons; fails where one has none
    python -m benchmarks.constants --sweep -o FILE.json           # halves and doubles each; goes on where it was ended
    python -m benchmarks.constants --document docs/CONSTANTS.md -o FILE.json

Cases are those of benchmarks.frozen; their records are made once and kept.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from benchmarks.constants.document import written
from benchmarks.constants.listing import constants, unused, without_reason
from benchmarks.constants.sweep import CASES, read_swept, sweep
from ema_tools.base.errors import InputError

_RECORDS = Path(__file__).resolve().parents[2] / "build" / "constants"


def _chosen_cases(texts: list[str]) -> list[str]:
    from benchmarks import frozen

    found = [case.name for case in frozen.CASES if any(text in case.name for text in texts)] if texts else list(CASES)
    if not found:
        raise InputError(f"--cases {texts[0]}: no such case: python -m benchmarks.frozen has them all")
    return found


def main() -> int:
    """Entry point; 0 when every constant has a reason and a use."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sweep", action="store_true", help="halve and double the constants")
    parser.add_argument("--only", action="append", default=[], help="only constants with this in module:name; may be given several times")
    parser.add_argument(
        "--cases", action="append", default=[], help="cases with this in their name instead of the usual few; may be given several times"
    )
    parser.add_argument("-o", "--output", type=Path, help="file of the sweep's rows")
    parser.add_argument(
        "--records", type=Path, default=_RECORDS, help="folder of the records, made where absent; delete it when the truth plant changes"
    )
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="processes at once, one on each core")
    parser.add_argument("--document", type=Path, help="write the table there")
    parser.add_argument(
        "--keep", action="store_true", help="with --document: of constants that FILE.json does not hold, what the document said before"
    )
    arguments = parser.parse_args()
    found = constants()
    chosen = [one for one in found if not arguments.only or any(text in one.key for text in arguments.only)]
    try:
        if not chosen:
            raise InputError(f"--only {arguments.only[0]}: no constant has this in its module:name: run without --only for all of them")
        if arguments.sweep:
            if arguments.output is None:
                raise InputError("--sweep: say with -o where its rows are kept")
            sweep(
                chosen,
                _chosen_cases(arguments.cases),
                arguments.output,
                arguments.records,
                arguments.workers,
                lambda line: print(line, flush=True),
            )
        if arguments.document is not None:
            swept = read_swept(arguments.output) if arguments.output is not None else None
            earlier = arguments.document.read_text(encoding="utf-8") if arguments.keep and arguments.document.exists() else ""
            arguments.document.write_text(written(found, swept, earlier), encoding="utf-8")
    except InputError as error:
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print(f"ended: the same call goes on from {arguments.output}", file=sys.stderr)
        return 130
    if not arguments.sweep and arguments.document is None:
        for one in chosen:
            print(f"{one.key} = {one.text}: {one.reason or '?'} [{one.set_by or '?'}]")
    problems = [*without_reason(found), *(f"{key}: nothing reads it: remove it" for key in unused())]
    for problem in problems:
        print(problem, file=sys.stderr)
    print(f"{len(found)} constants, {len(problems)} problems")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
