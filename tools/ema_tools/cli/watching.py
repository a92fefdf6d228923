"""`ema watch`: a recording followed on a local page while another program writes it."""

from __future__ import annotations

import sys
import time
import webbrowser
from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from ema_tools.cli.exit_codes import exit_code_option, leave, of_identification
from ema_tools.cli.greedy import TakesHealthy, healthy_option
from ema_tools.cli.options import command_line, json_option, save, writable
from ema_tools.words.terminal.console import complain, output

if TYPE_CHECKING:
    from ema_tools.results.identification import IdentificationResult
    from ema_tools.tasks.identify import Identified
    from ema_tools.tasks.watch import Watch

_POLL_S = 0.2  # between two looks at the file [layout]


@click.command(cls=TakesHealthy, short_help="Follow a recording that grows, on a local page.")
@click.argument("actuator")
@click.argument("file")
@healthy_option("Records of the healthy machine; those that ACTUATOR names when there are none.")
@click.option(
    "--quiet",
    "quiet_s",
    type=click.FloatRange(0.2, 3600.0),
    default=3.0,
    show_default=True,
    help="Seconds without a further row after which the recording is complete.",
)
@click.option("--once", is_flag=True, help="End after the first verdict, and not by Ctrl-C.")
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port of the page; a free one when absent.")
@click.option("--open", "opens", is_flag=True, help="Open the page in the browser.")
@exit_code_option
@json_option
def watch(
    actuator: str,
    file: str,
    healthy: tuple[str, ...],
    quiet_s: float,
    once: bool,
    port: int,
    opens: bool,
    by_verdict: bool,
    json_path: str | None,
    force: bool,
) -> None:
    """Follow FILE, a recording that another program is still writing, beside ACTUATOR's model.

    FILE is a CSV that grows, a named pipe, or a serial line that stty has set up. The page shows its curves and what the onboard search reads so far, on this machine's
    loopback address alone; once no further row comes the verdict of ema identify is said there and here. Ctrl-C ends it.
    """
    from ema_tools.data.actuator import read_actuator
    from ema_tools.data.any_record import record_files
    from ema_tools.data.growing import Growing
    from ema_tools.data.records import read_record
    from ema_tools.tasks.watch import Watch
    from ema_tools.words.live.page import page
    from ema_tools.words.live.server import LiveServer
    from ema_tools.words.live.state import state
    from ema_tools.words.terminal import show

    healthy = record_files(healthy)
    writable(json_path=json_path, force=force, inputs=(actuator, file, *healthy))
    model = read_actuator(actuator)
    growing = Growing(file)
    followed = Watch(model, growing, [read_record(path, model) for path in healthy], quiet_s)
    server = LiveServer(
        page(model.name, growing.file),
        lambda seen: None if seen == str(followed.seen.version) else state(followed.seen, model, growing.file),
        port,
    )
    result: IdentificationResult | None = None
    told: Identified | None = None
    try:
        output().print(f"{growing.file} is followed on {server.url} ; Ctrl-C ends it", highlight=False)
        if opens:
            webbrowser.open(server.url)
        while not (once and followed.seen.phase == "judged"):
            before = followed.seen
            if not followed.step():
                time.sleep(_POLL_S)
                continue
            _say_news(followed, before.trouble, len(before.notes))
            if followed.seen.found is not None and followed.seen.found is not told:
                told = followed.seen.found
                result = _result(told, growing.file, followed.seen.healthy, model.name)
                show.identification(output(), result)
                if followed.seen.healthy:
                    show.say(output(), f"held against {', '.join(followed.seen.healthy)}")
                output().print()
    except KeyboardInterrupt:
        output().print()
    finally:
        server.close()
        growing.close()
    if result is None:
        output().print("ended without a verdict", highlight=False)
        if once:
            sys.exit(1)
        return
    save(json_path, result, force)
    if by_verdict:
        leave(of_identification(result))


def _say_news(followed: Watch, trouble: str, notes: int) -> None:
    """What is wrong with the file, once."""
    for note in followed.seen.notes[notes:]:
        complain(note)
    if followed.seen.trouble and followed.seen.trouble != trouble:
        complain(followed.seen.trouble)


def _result(found: Identified, file: str, healthy: Sequence[str], actuator: str) -> IdentificationResult:
    from ema_tools.results.provenance import provenance
    from ema_tools.words.answers.identification import identification

    held = {"healthy": ", ".join(healthy)} if healthy else {}
    return identification(found, file, provenance(command_line(), actuator=actuator, record=file, seed=found.seed, **held))
