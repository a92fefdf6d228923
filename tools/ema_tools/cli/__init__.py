"""The command `ema`: words to functions. Exit code 0 when it did its job, 1 on a bad input with one line that names it, 2 on wrong usage.

Modules behind a command are imported by the command, so that help and errors come at once.
"""

from __future__ import annotations

import contextlib
import io
import itertools
import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from ema_tools.base.one_thread import one_thread_unless_told

# Before anything imports NumPy.
one_thread_unless_told()

from ema_tools import __version__
from ema_tools.base.errors import InputError, LibraryError, MissingSignal
from ema_tools.cli.exit_codes import exit_code_option, leave, of_diagnosis, of_identification
from ema_tools.cli.fleets import fleet
from ema_tools.cli.greedy import TakesHealthy, healthy_option
from ema_tools.cli.importing import import_group
from ema_tools.cli.loop import loop
from ema_tools.cli.options import command_line, fix_option, json_option, method_option, pictures_option, precision_option, save, writable
from ema_tools.cli.picturing import draw, picture_files, say_drawn
from ema_tools.cli.sections import InSections
from ema_tools.cli.watching import watch
from ema_tools.words.terminal.console import complain, output, progress

if TYPE_CHECKING:
    from ema_tools.results.diagnosis import Method
    from ema_tools.results.reading import Result

# Every reader of JSON holds it exactly, and the host program takes no larger one.
SEED_MAX = 2**53 - 1

_NAMED = 5  # records that an actuator's file names as its source [layout]
_CONTEXT = {"help_option_names": ["-h", "--help"], "max_content_width": 110}


@click.group(cls=InSections, context_settings=_CONTEXT)
@click.version_option(__version__, prog_name="ema")
def cli() -> None:
    """Model, identify and watch over an electromechanical actuator.

    ACTUATOR is a TOML file, or reference, which ships with the tools; REC a recording (CSV, .mat or .parquet).
    """


@cli.command(short_help="Simulate ACTUATOR under a command.")
@click.argument("actuator")
@click.option(
    "--command",
    "command_text",
    required=True,
    metavar="CMD",
    help="A recording, or chirp, multisine, triangle, trapezoid, step with numbers: chirp:amplitude_mm=2,end_hz=4.",
)
@click.option("-o", "--output", "out", required=True, metavar="REC.csv", help="The recording to write.")
@click.option(
    "--set", "settings", multiple=True, metavar="NAME=VALUE", help="Change a value of the actuator: screw.csj_Nm=0.3. May be repeated."
)
@click.option("--noise", metavar="COLUMN=STD,...", help="Add white noise: position_mm=0.005,current_A=0.03.")
@click.option("--seed", type=click.IntRange(0, SEED_MAX), default=1, show_default=True, help="Seed of the noise.")
@precision_option("64")
@json_option
def simulate(
    actuator: str,
    command_text: str,
    out: str,
    settings: tuple[str, ...],
    noise: str | None,
    seed: int,
    precision: str,
    json_path: str | None,
    force: bool,
) -> None:
    """Simulate ACTUATOR under a command and write the recording."""
    from ema_tools.data.actuator import read_actuator
    from ema_tools.data.commands import make_command
    from ema_tools.data.records import write_record
    from ema_tools.results.files import SimulationResult
    from ema_tools.tasks import simulate as work

    writable(out, json_path=json_path, force=force, inputs=(actuator, *filter(os.path.isfile, (command_text,))))
    model = work.with_settings(read_actuator(actuator), settings)
    std = work.noise_of(noise)
    command = make_command(command_text, model)
    record = work.simulate_record(model, command, int(precision), std, seed)
    comments = [f"Simulated: {model.name}, {command.text}, {precision} bit."]
    if settings:
        comments.append(f"Changed: {', '.join(settings)}.")
    if std:
        comments.append(f"White noise: {', '.join(f'{name} {value:g}' for name, value in std.items())}, seed {seed}.")
    write_record(out, record, tuple(comments), force, 17 if precision == "64" else 9)
    found = SimulationResult("simulate", actuator, out, record.rows, record.period_s, tuple(settings), std, seed, int(precision))
    save(json_path, found, force)
    output().print(f"{out}: {record.rows} rows, {record.rows * record.period_s:g} s", highlight=False)


@cli.command(cls=TakesHealthy, short_help="Say where ACTUATOR's model fails on REC.")
@click.argument("actuator")
@click.argument("record")
@healthy_option("Records of the healthy machine under the same command, two or more; those that ACTUATOR names when there are none.")
@click.option("--report", "page", metavar="FILE.html", help="Write the page there: signals, where the model fails, and the workbench.")
@precision_option("64")
@pictures_option
@json_option
def compare(
    actuator: str,
    record: str,
    healthy: tuple[str, ...],
    page: str | None,
    precision: str,
    pictures: str | None,
    json_path: str | None,
    force: bool,
) -> None:
    """Compare ACTUATOR's model with a RECORD, and say where it fails; by the balance of forces alone where the controller is not known.

    The weighted error is that of the model with today's CSJ and BLK, as ema add and ema diagnose state it.
    """
    from ema_tools.compare.comparison import compare as work
    from ema_tools.compare.motion_comparison import compare_motion
    from ema_tools.compare.validity import unlike
    from ema_tools.data.actuator import read_actuator
    from ema_tools.data.any_record import read_any_record, record_files
    from ema_tools.data.motion_records import MotionRecord
    from ema_tools.data.records import Record
    from ema_tools.results.provenance import curves, provenance
    from ema_tools.tasks.baseline_records import given_or_own
    from ema_tools.tasks.model_error import error_where_known
    from ema_tools.tasks.workbench import bench
    from ema_tools.words.advice import with_next
    from ema_tools.words.answers.comparison import comparison
    from ema_tools.words.terminal import show
    from ema_tools.words.terminal.next_step import say_next

    healthy = record_files(healthy)
    writable(page, *picture_files(pictures, "compare", record), json_path=json_path, force=force, inputs=(actuator, record, *healthy))
    model = read_actuator(actuator, complete=False)
    measured = read_any_record(record, model)
    with progress("comparing", 3) as bar:
        found = compare_motion(model, measured) if isinstance(measured, MotionRecord) else work(model, measured, int(precision), bar.update)
    error = None
    if isinstance(measured, Record) and found.simulation is not None:
        found = replace(found, unlike=unlike(model, measured, found.simulation))
        references = [one for one in given_or_own(model, [measured], healthy) if isinstance(one, Record)]
        error = error_where_known(model, measured, references, asked=bool(healthy))
    origin = provenance(command_line(), actuator=model.name, record=measured.file, precision=f"{precision} bit")
    result = comparison(found, origin, curves(measured, model=found.simulation) if isinstance(measured, Record) else None, error)
    result = with_next(replace(result, workbench=bench(model, measured) if (json_path or page) and isinstance(measured, Record) else None))
    save(json_path, result, force)
    _page(page, result, force)
    show.comparison(output(), result, model.name)
    say_next(output(), result)
    _written(page)
    draw(pictures, result, record, force)


@cli.command(short_help="Fit ACTUATOR to healthy records of a unit.")
@click.argument("actuator")
@click.argument("records", nargs=-1, required=True, metavar="REC...")
@click.option("-o", "--output", "out", required=True, metavar="NEW.toml", help="The calibrated actuator to write.")
@click.option("--fit", "names", metavar="NAME,...", help="Fit only these values, for example screw.csj_Nm,screw.blk_mm.")
@click.option(
    "--closed-loop/--balances-only",
    "loop",
    default=None,
    help="Keep the fit of the simulated loop, or that of the balances; without either, the loop's where it is clearly better.",
)
@click.option(
    "--base-only",
    is_flag=True,
    help="Fit base values alone, though two or more records run the same command: no effects that the unit always has, the thresholds as they are.",
)
@click.option(
    "--false-alarm",
    type=click.FloatRange(0.0, 0.5, min_open=True, max_open=True),
    help="Set the thresholds so that this share of the ground tests of the healthy unit exceeds one of them, by the scatter of its runs alone: 0.01. "
    "Unless told they stay as stated, and grow where more than 0.01 would.",
)
@method_option
@fix_option
@json_option
def calibrate(
    actuator: str,
    records: tuple[str, ...],
    out: str,
    names: str | None,
    loop: bool | None,
    base_only: bool,
    false_alarm: float | None,
    method: Method | None,
    fixed: tuple[str, ...],
    json_path: str | None,
    force: bool,
) -> None:
    """Fit ACTUATOR to healthy records and write NEW.toml, comments kept.

    Where the controller is not known, base values and the sizes of the model's own effects are fitted by the balance of forces. REC takes files, patterns and folders.
    Two or more records of the same command show the unit itself: effects that it always has are put in, and the shifts that are called a fault follow the scatter of its runs.
    """
    from ema_tools.data.actuator import read_actuator
    from ema_tools.data.any_record import read_any_record, record_files
    from ema_tools.data.machine_state import BaselineRecords
    from ema_tools.data.records import Record
    from ema_tools.results.provenance import provenance
    from ema_tools.select.fixes import fixes_of
    from ema_tools.select.healthy_records import check_once
    from ema_tools.tasks.calibrate import calibrate as work
    from ema_tools.tasks.calibrate_by_balance import calibrate_by_balance
    from ema_tools.tasks.method import check_fixes, chosen_for_calibration
    from ema_tools.tasks.own_machine import of_own_machine, own_machine
    from ema_tools.words.advice import with_next
    from ema_tools.words.answers.calibration import calibration, calibration_by_balance
    from ema_tools.words.terminal import show
    from ema_tools.words.terminal.next_step import say_next

    records = record_files(records)
    writable(out, json_path=json_path, force=force, inputs=(actuator, *records))
    model = read_actuator(actuator, complete=False)
    given = [read_any_record(record, model) for record in records]
    check_once(given)
    way, fixes = chosen_for_calibration(model, given, method), fixes_of(model, fixed)
    check_fixes(way, fixes)
    origin = provenance(command_line(), actuator=model.name, records=", ".join(record.file for record in given))
    said = "; ".join(filter(None, (model.about.get("source"), f"calibrated on {_few([record.file for record in given])}")))
    if way.method == "balance":
        of_simulation = {"--fit": names, "--closed-loop or --balances-only": loop is not None, "--base-only": base_only}
        wrong = next((option for option, value in {**of_simulation, "--false-alarm": false_alarm}.items() if value), "")
        if wrong:
            raise InputError(f"{wrong}: by the balance of forces ({way.because}) base values are kept by --fix NAME: leave it out")
        with progress("calibrating", 100) as bar:
            by_balance = calibrate_by_balance(model, given, fixes, lambda share, text: bar.update(100.0 * share, text))
        by_balance.actuator.changed({}, {"source": said}).write(out, force)
        told = with_next(calibration_by_balance(by_balance, out, origin, way.because))
        save(json_path, told, force)
        show.calibration(output(), told)
        say_next(output(), told)
        output().print(f"{out} written", highlight=False)
        return
    measured = [record for record in given if isinstance(record, Record)]
    chosen = tuple(filter(None, (name.strip() for name in names.split(",")))) if names else None
    with progress("calibrating", 3) as bar:
        found = work(model, measured, chosen, loop, bar.update)
        own = None if base_only or chosen else own_machine(found.actuator, measured, lambda _, text: bar.update(3, text), false_alarm)
    if own is None and false_alarm is not None:
        raise InputError(
            f"--false-alarm {false_alarm:g}: no two of the records run the same command, or a value is left out: the scatter of their runs is not known"
        )
    if own is not None:
        found = of_own_machine(found, own, measured)
    unit = found.actuator.changed({}, {"source": said})
    replace(unit, baseline=BaselineRecords.of(measured) if own is not None else None, findings=model.findings).write(out, force)
    result = with_next(replace(calibration(found, out, origin, own), method_reason=way.because))
    save(json_path, result, force)
    show.calibration(output(), result)
    say_next(output(), result)
    output().print(f"{out} written", highlight=False)


@cli.command(cls=TakesHealthy, short_help="Find CSJ and BLK on REC as the onboard module does.")
@click.argument("actuator")
@click.argument("record")
@healthy_option("Records of the healthy machine, which say what it is like and how it scatters.")
@click.option("--seed", type=click.IntRange(0, SEED_MAX), help="Seed of the search; the actuator's own when absent.")
@click.option("--seeds", type=click.IntRange(min=1), default=1, show_default=True, help="Repeat with this many seeds and show the spread.")
@click.option(
    "--weight",
    "weights",
    metavar="COLUMN=W,...",
    help="Weights of the objective, per squared unit: position_mm=1,current_A=0.01. The rod position alone when absent.",
)
@click.option(
    "--values",
    "value_names",
    metavar="NAME[=LOW..HIGH],...",
    help="Find up to eight values at once beside them, by every signal of the record: screw.csj_Nm,motor.resistance_ohm=0.8..1.3. Says which of them the record determines.",
)
@click.option(
    "--fitted", metavar="NEW.toml", help="Write the actuator there with its baseline records, and with the identified values as a finding."
)
@click.option("--no-guard", is_flag=True, help="Do not look for a missing effect behind a fault: what the onboard module alone would say.")
@click.option(
    "--table",
    metavar="FILE.h",
    help="Guard the answer by this table alone, as firmware does with it: written by `ema export --signatures`.",
)
@click.option("--report", "page", metavar="FILE.html", help="Write the page there: verdict, both sizes, signals and what objects.")
@precision_option("32")
@exit_code_option
@pictures_option
@json_option
def identify(
    actuator: str,
    record: str,
    healthy: tuple[str, ...],
    seed: int | None,
    seeds: int,
    weights: str | None,
    value_names: str | None,
    fitted: str | None,
    no_guard: bool,
    table: str | None,
    page: str | None,
    precision: str,
    by_verdict: bool,
    pictures: str | None,
    json_path: str | None,
    force: bool,
) -> None:
    """Find CSJ and BLK on RECORD with the onboard module's own search.

    Where it finds a fault, or the model does not explain the record, a missing effect is sought behind it.
    A file that ema calibrate wrote names the unit's healthy runs, and they serve as --healthy where none is given.
    """
    from ema_tools.data.actuator import read_actuator
    from ema_tools.data.any_record import record_files
    from ema_tools.data.machine_state import BaselineRecords
    from ema_tools.data.records import read_record, simulated
    from ema_tools.plant.native import SearchSettings
    from ema_tools.plant.signatures_header import read_signatures
    from ema_tools.results.provenance import curves, provenance
    from ema_tools.select.known_machine import silent
    from ema_tools.tasks.baseline_records import baseline_records_of, why_not_used, with_state
    from ema_tools.tasks.identify import identify as work
    from ema_tools.tasks.model_error import error_where_known
    from ema_tools.tasks.objective_shape import shape_of
    from ema_tools.tasks.onboard_search import search_warnings, weight_of
    from ema_tools.tasks.several_values import searched_of, several_values
    from ema_tools.tasks.workbench import bench
    from ema_tools.words.advice import with_next
    from ema_tools.words.answers.comparison import error_entry
    from ema_tools.words.answers.identification import identification, values
    from ema_tools.words.sentences.paths import with_paths
    from ema_tools.words.terminal import show
    from ema_tools.words.terminal.next_step import say_next

    healthy = record_files(healthy)
    drawn_to = picture_files(pictures, "identify", record)
    writable(fitted, page, *drawn_to, json_path=json_path, force=force, inputs=(actuator, record, *healthy, *filter(None, [table])))
    shown = bool(json_path or page or pictures)
    model = read_actuator(actuator)
    measured = read_record(record, model)
    # what the onboard module alone would say knows of no other record
    asked = bool(healthy) or no_guard or table is not None
    references = [read_record(path, model) for path in healthy] if asked else baseline_records_of(model, measured)
    weight = weight_of(weights)
    signatures = read_signatures(table) if table else None
    if value_names is not None:
        searched_of(model, value_names)
    with progress("identifying", model["search.evaluation_budget"]) as bar:
        found = work(
            model,
            measured,
            references,
            SearchSettings(seed=seed, weight=weight),
            seeds,
            int(precision),
            lambda run, _, best, _tried: bar.update(run, f"best {best:.3g}"),
            not no_guard,
            signatures,
            bar.note,
        )
        bar.note("looking round")
        shape = shape_of(found, mapped=shown)
        several = None
        if value_names is not None:
            several = several_values(
                found.healthy, measured, value_names, int(precision), lambda runs, misfit: bar.update(runs, f"misfit {misfit:.3g}")
            )
    if fitted:
        # the model as it is: today's values are a finding
        kept = model.baseline or BaselineRecords.of(references)
        machine = replace(model.changed({}), baseline=kept)
        replace(with_state(machine, model, (), model, (), measured, found.actuator, "identify"), baseline=kept).write(fitted, force)
    held = {"healthy": ", ".join(one.file for one in references)} if references else {}
    origin = provenance(command_line(), actuator=model.name, record=measured.file, seed=found.seed, precision=f"{precision} bit", **held)
    drawn = None
    if shown:
        drawn = curves(measured, before=simulated(found.healthy, measured), after=simulated(found.actuator, measured))
    # behind a table the search begins as the table says
    warned = () if signatures else search_warnings(found.healthy, SearchSettings(seed=seed, weight=weight))
    more = values(several) if several is not None else {}
    result = identification(found, measured.file, origin, drawn, shape, warnings=warned or None, **more)
    given = healthy or model.healthy
    result = replace(
        result,
        error=None if no_guard or table is not None else error_entry(error_where_known(model, measured, references, asked=False)),
        sentence=with_paths(result.sentence, actuator, [record], given),
        reasons=tuple(with_paths(reason, actuator, [record], given) for reason in result.reasons),
        workbench=bench(found.healthy, measured) if json_path or page else None,
    )
    result = with_next(result)
    save(json_path, result, force)
    _page(page, result, force)
    show.identification(output(), result)
    if references and not asked:
        show.say(output(), f"compared with the baseline records of {model.file}: {_few([one.file for one in references])}")
    say_next(output(), result)
    if not asked and not references and (unused := why_not_used(model, measured)):
        complain(unused)
    for name in silent(measured):
        complain(f"{measured.file}: {name} does not change and is left out: check that its sensor was connected")
    _warn_of_search(actuator, warned)
    _written(page)
    draw(pictures, result, record, force)
    if by_verdict:
        leave(of_identification(result))


@cli.command(cls=TakesHealthy, short_help="Say which physical effect ACTUATOR's model lacks on REC.")
@click.argument("actuator")
@click.argument("record", nargs=-1, required=True, metavar="REC...")
@healthy_option(
    "Records of the healthy machine: by simulation under the same command, two or more, those of the hold-out's command serve the hold-out; by the balance of any motion, three or more."
)
@click.option("--holdout", metavar="REC", help="A record that nothing is fitted to, best of another command.")
@method_option
@fix_option
@click.option("--report", "page", metavar="FILE.html", help="Write the page with the pictures there.")
@click.option("--fitted", metavar="NEW.toml", help="Write the actuator with what was found there, when it is recommended.")
@exit_code_option
@pictures_option
@json_option
def diagnose(
    actuator: str,
    record: tuple[str, ...],
    healthy: tuple[str, ...],
    holdout: str | None,
    method: Method | None,
    fixed: tuple[str, ...],
    page: str | None,
    fitted: str | None,
    by_verdict: bool,
    pictures: str | None,
    json_path: str | None,
    force: bool,
) -> None:
    """Say which physical effect ACTUATOR's model lacks on REC, or that none is missing, or that the library does not hold it.

    REC and --healthy take files, patterns and folders. With --healthy the question is what has changed on this machine, without it what the model lacks.
    A file that ema calibrate wrote names the unit's healthy runs, and they serve as --healthy where none is given.
    Several records are held out in turn: what helps on all of them is no chance.
    """
    from ema_tools.data.actuator import read_actuator
    from ema_tools.data.any_record import read_any_record, record_files
    from ema_tools.data.records import Record, simulated
    from ema_tools.results.provenance import curves, provenance
    from ema_tools.select.fixes import fixes_of
    from ema_tools.tasks.baseline_records import by_sheet, carried, given_or_own, with_state
    from ema_tools.tasks.diagnose import Answer
    from ema_tools.tasks.method import chosen, diagnosed
    from ema_tools.tasks.workbench import bench
    from ema_tools.words.advice import with_next
    from ema_tools.words.answers.method import diagnosis
    from ema_tools.words.terminal import show

    record, healthy = record_files(record, holdout), record_files(healthy, holdout)
    drawn_to = picture_files(pictures, "diagnose", record[0])
    writable(page, fitted, *drawn_to, json_path=json_path, force=force, inputs=(actuator, *record, *healthy, *filter(None, (holdout,))))
    model = read_actuator(actuator, complete=False)
    records = [read_any_record(path, model) for path in record]
    measured = records[0]
    references = given_or_own(model, records, healthy) if healthy or method != "balance" else []
    other = read_any_record(holdout, model) if holdout else None
    way, fixes = chosen(model, records, references, other, method), fixes_of(model, fixed)
    with progress("diagnosing", 100) as bar:
        found = diagnosed(model, records, references, other, lambda share, text: bar.update(100.0 * share, text), way, fixes)
    drawn = entry = None
    if (json_path or page or pictures) and isinstance(measured, Record) and not model.absent:
        evidence = found.evidence if isinstance(found, Answer) else None
        first = evidence.actuator if evidence is not None else found.known
        # without healthy records the unit's own parameters have moved, and beside them what scatters, though no effect was fitted
        moved = found.fits or evidence is not None
        entry = bench(first, measured, evidence)
        after = found.on_its_day if isinstance(found, Answer) else found.fitted
        drawn = curves(measured, before=simulated(first, measured), after=simulated(after, measured) if moved else None)
    compared = ", ".join(one.file for one in references) or ("none" if isinstance(found, Answer) else "none, parts of the records")
    origin = provenance(command_line(), actuator=model.name, record=", ".join(one.file for one in records), healthy=compared)
    result = replace(diagnosis(found, origin, drawn, way.because), workbench=entry)
    result = with_next(result)
    save(json_path, result, force)
    _page(page, result, force)
    kept = fitted if found.recommended else None
    if kept:
        machine = carried(found.machine, model)
        if isinstance(found, Answer):
            began = [one.name for one in found.effects]
            repeats = [one for one in references if isinstance(one, Record)] if found.evidence.relative else []
            machine = with_state(found.machine, model, repeats, found.evidence.actuator, began, found.record, found.fitted, "diagnose")
            machine = machine if repeats else by_sheet(machine)
        machine.write(kept, force)
    show.diagnosed(output(), result, found.diagnosis if isinstance(found, Answer) else None)
    _written(page, kept)
    if fitted and not kept:
        complain(f"{fitted} is not written: nothing was found that would better {actuator}")
    draw(pictures, result, record[0], force)
    if by_verdict:
        leave(of_diagnosis(result))


def _warn_of_search(actuator: str, warnings: tuple[str, ...]) -> None:
    """One line where the search's settings will not reach the lowest cost."""
    if warnings:
        complain(f"{actuator}: [search]: {'; '.join(warnings)}")


def _few(names: Sequence[str]) -> str:
    """Names for a file: all of a few, else the first and how many more."""
    return ", ".join(names) if len(names) <= _NAMED else f"{names[0]} and {len(names) - 1} more"


def _written(*paths: str | None) -> None:
    for path in filter(None, paths):
        output().print(f"{path} written", highlight=False)


def _page(path: str | None, result: Result, force: bool) -> None:
    """Write the page of one result when it was asked for."""
    if path:
        from ema_tools.base.files import write_text
        from ema_tools.results.codec import to_json
        from ema_tools.words.page.page import render
        from ema_tools.words.page.results import parse_result

        write_text(path, render([parse_result(to_json(result), path, Path(path).stem)], command_line()), force)


@cli.command(cls=TakesHealthy, short_help="Put EFFECT into ACTUATOR's model and watch the error fall.")
@click.argument("actuator")
@click.argument("effect")
@click.argument("given", nargs=-1, metavar="[EFFECT...] [REC...]")
@click.option("-o", "--output", "out", required=True, metavar="NEW.toml", help="The actuator with the effect.")
@click.option(
    "--fit",
    "fits",
    multiple=True,
    metavar="REC",
    help="A record that the effect is fitted to, or REC behind the effect; several by the balance of forces. Files, patterns, folders.",
)
@healthy_option(
    "Records of the healthy machine under the same command; two or more. By simulation alone: by the balance of forces ACTUATOR says what the machine is like, so calibrate it on them first."
)
@click.option("--holdout", metavar="REC", help="A record that nothing is fitted to, best of another command.")
@click.option(
    "--known",
    is_flag=True,
    help="ACTUATOR is this very machine, calibrated: only the effect is fitted, beside a CSJ and BLK that may have changed, as ema identify does.",
)
@click.option(
    "--set", "settings", multiple=True, metavar="FIELD=VALUE", help="Without a record: the effect's values, for example rise_degC=30."
)
@method_option
@fix_option
@click.option("--report", "page", metavar="FILE.html", help="Write the page with the fall of the error there.")
@json_option
def add(
    actuator: str,
    effect: str,
    given: tuple[str, ...],
    out: str,
    fits: tuple[str, ...],
    healthy: tuple[str, ...],
    holdout: str | None,
    known: bool,
    settings: tuple[str, ...],
    method: Method | None,
    fixed: tuple[str, ...],
    page: str | None,
    json_path: str | None,
    force: bool,
) -> None:
    """Put EFFECT, or several at once, into ACTUATOR's model, fit to a record, and show how the error falls.

    Where the controller is not known, or several records are given, it is fitted by the balance of forces as ema diagnose does, together with base values and the model's own effects.
    """
    from ema_tools.data.actuator import read_actuator
    from ema_tools.data.any_record import read_any_record, record_files
    from ema_tools.data.records import Record, simulated
    from ema_tools.library.definitions import load_definitions
    from ema_tools.library.faults import FAULTS
    from ema_tools.results.provenance import curves, provenance
    from ema_tools.select.fixes import fixes_of
    from ema_tools.tasks.add import add as work
    from ema_tools.tasks.add import add_to_known, add_together
    from ema_tools.tasks.add_by_balance import add_by_balance
    from ema_tools.tasks.baseline_records import by_sheet, carried, given_or_own, with_state
    from ema_tools.tasks.effects import find_effect
    from ema_tools.tasks.method import check_fixes, chosen
    from ema_tools.tasks.model_error import model_error
    from ema_tools.tasks.simulate import with_settings
    from ema_tools.tasks.workbench import bench
    from ema_tools.words.advice import with_next
    from ema_tools.words.answers.addition import addition, addition_by_balance, setting
    from ema_tools.words.terminal import show

    names = {row.name for row in load_definitions().effects}
    more = tuple(itertools.takewhile(lambda word: word in names, given))
    files, healthy = record_files((*given[len(more) :], *fits), holdout), record_files(healthy, holdout)
    writable(out, page, json_path=json_path, force=force, inputs=(actuator, *healthy, *files, *filter(None, (holdout,))))
    model = read_actuator(actuator, complete=False)
    if effect in FAULTS:
        raise InputError(f"add {effect}: no effect but a value that every model has, {FAULTS[effect]}: ema identify finds it")
    effect = find_effect(effect).name
    together = tuple(dict.fromkeys((effect, *more)))
    if len(together) > 1 and not files:
        raise InputError(f"add {' '.join(together)}: nothing to fit them to: give --fit REC")
    if not files:
        if not settings or page or holdout or healthy or known or fixed or method:
            raise InputError(
                f"add {effect}: nothing to fit it to: give --fit REC, or its values with --set FIELD=VALUE and no other option"
            )
        made = with_settings(model, tuple(f"effects.{effect}.{one}" for one in settings))
        if effect not in made.active_effects:
            raise InputError(f"add {effect}: {', '.join(settings)}: at these values the effect is absent: give its size with --set")
        carried(made, model).write(out, force)
        told = setting(made, effect, model, out, provenance(command_line(), actuator=model.name))
        save(json_path, told, force)
        if told.replaced:
            show.say(output(), told.sentence)
        output().print(f"{out} written", highlight=False)
        return
    if settings:
        raise InputError(f"add {effect}: --set {settings[0]}: with --fit the values come from the record: leave one of the two out")
    if known and healthy:
        raise InputError(f"add {effect}: --known: the healthy records say what the machine is like: leave one of the two out")
    records = [read_any_record(path, model) for path in files]
    references = given_or_own(model, records, healthy) if healthy or not (known or method == "balance") else []
    other = read_any_record(holdout, model) if holdout else None
    fixes = fixes_of(model, fixed)
    if known and (method == "balance" or len(records) > 1):
        raise InputError(
            f"add {effect}: --known goes by simulation, of one record: leave --known out, or give one record and no --method balance"
        )
    way = chosen(model, records, references, other, "simulation" if known else method)
    check_fixes(way, fixes)
    if len(together) > 1 and way.method == "balance":
        raise InputError(
            f"add {' '.join(together)}: the balance of forces adds one effect at a time: add {effect} first, then the next to the new file"
        )

    def tell(share: float, text: str) -> None:
        bar.update(100.0 * share, text)

    if way.method == "balance":
        if references:
            raise InputError(
                f"add {effect}: --healthy: the balance fits the effect to the records of today alone: leave it out and calibrate the actuator on the healthy ones first"
                f" (ema calibrate {actuator} HEALTHY... -o NEW.toml), or give --method simulation"
            )
        with progress("adding", 100) as bar:
            by_balance = add_by_balance(model, effect, records, () if other is None else (other,), fixes, tell)
        said = "; ".join(filter(None, (model.about.get("source"), f"{effect} fitted on {_few([one.file for one in records])}")))
        carried(by_balance.actuator.changed({}, {"source": said}), model).write(out, force)
        origin = provenance(command_line(), actuator=model.name, record=", ".join(one.file for one in records))
        told = with_next(addition_by_balance(by_balance, out, origin, way.because))
        save(json_path, told, force)
        _page(page, told, force)
        show.added(output(), told)
        output().print(f"{out} written", highlight=False)
        return
    # the method by simulation is chosen only where every record can be simulated
    (measured,) = [one for one in records if isinstance(one, Record)]
    repeats = [one for one in references if isinstance(one, Record)]
    apart = other if isinstance(other, Record) else None
    with progress("adding", 100) as bar:
        if len(together) > 1:
            found = add_together(model, together, measured, repeats, apart, known, tell)
        else:
            found = add_to_known(model, effect, measured, apart, tell) if known else work(model, effect, measured, repeats, apart, tell)
    said = "; ".join(filter(None, (model.about.get("source"), f"{', '.join(together)} fitted on {measured.file}")))
    drawn, evidence = None, found.fit.view.evidence
    machine = found.machine.changed({}, {"source": said})
    machine = with_state(machine, model, repeats if evidence.relative else [], evidence.actuator, together, measured, found.fitted, "add")
    machine = machine if known or evidence.relative else by_sheet(machine)
    machine.write(out, force)
    # the number that ema compare states of the new file
    found = found.with_last_error(model_error(machine, measured, repeats if evidence.relative else []).fitted)
    if json_path or page:
        drawn = curves(measured, before=simulated(evidence.actuator, measured), after=simulated(found.fitted, measured))
    result = addition(found, measured.file, out, provenance(command_line(), actuator=model.name, record=measured.file), drawn)
    result = with_next(
        replace(result, method_reason=way.because, workbench=bench(evidence.actuator, measured, evidence) if drawn else None)
    )
    save(json_path, result, force)
    _page(page, result, force)
    show.added(output(), result)
    output().print(f"{out} written", highlight=False)


@cli.command(name="next", short_help="Find the safe command that tells look-alikes apart.")
@click.argument("actuator")
@click.option(
    "--between",
    "first",
    metavar="EFFECT EFFECT...",
    help="The effects that are confused: two or more; csj and blk are taken too.",
)
@click.option(
    "--detect", is_flag=True, help="The smallest shifts of CSJ and BLK that the ground test finds, now and under other safe commands."
)
@click.option(
    "--false-alarm",
    type=click.FloatRange(0.0, 0.5, min_open=True, max_open=True),
    default=0.01,
    show_default=True,
    help="With --detect: share of the ground tests of a healthy machine that may exceed a threshold.",
)
@click.option(
    "--power",
    type=click.FloatRange(0.5, 1.0, min_open=True, max_open=True),
    default=0.95,
    show_default=True,
    help="With --detect: share of the shifts that are to be found.",
)
@click.option(
    "--runs", type=click.IntRange(2), default=3, show_default=True, help="With --detect: healthy runs that show mean and scatter."
)
@click.option("--command", "present", metavar="CMD", help="With --detect: the ground test as it is now; the reference chirp when absent.")
@click.option(
    "--scatter",
    metavar="csj=PERCENT,...",
    help="With --detect: by what healthy runs of it are read apart, standard deviations in %, as ema calibrate says; by the actuator's [scatter] when absent, else the usual.",
)
@click.argument("others", nargs=-1, metavar="")
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="NAME=VALUE",
    help="At which size: effects.constant_load.torque_Nm=0.01. The lower end of the usual when absent. May be repeated.",
)
@click.option("--channels", metavar="COLUMN,...", help="The signals that are recorded; all four when absent.")
@click.option(
    "--noise",
    metavar="COLUMN=STD,...",
    help="Noise of the sensors at 1 kHz; position_mm=0.002,motor_position_mm=0.002,current_A=0.03 when absent.",
)
@click.option(
    "--limit",
    "limit",
    metavar="NAME=VALUE,...",
    help="What is safe, in place of shares of what the machine can do: stroke_mm=5,speed_mm_s=40,current_A=8.",
)
@click.option(
    "--also", multiple=True, metavar="CMD", help="A command of your own beside the menu's: chirp:amplitude_mm=1,end_hz=6. May be repeated."
)
@json_option
def next_command(
    actuator: str,
    first: str | None,
    detect: bool,
    false_alarm: float,
    power: float,
    runs: int,
    present: str | None,
    scatter: str | None,
    others: tuple[str, ...],
    settings: tuple[str, ...],
    channels: str | None,
    noise: str | None,
    limit: str | None,
    also: tuple[str, ...],
    json_path: str | None,
    force: bool,
) -> None:
    """Say which safe command separates effects best that look alike, or that none does and what would; or how small a shift the ground test finds.

    ema next ACTUATOR --between EFFECT EFFECT...

    ema next ACTUATOR --detect
    """
    if detect == (first is not None):
        raise click.UsageError("give one of --between EFFECT EFFECT... and --detect")
    if detect and (others or settings):
        raise click.UsageError("effects and --set belong to --between")
    only = {"--false-alarm": "false_alarm", "--power": "power", "--runs": "runs", "--command": "present", "--scatter": "scatter"}
    given = [
        option for option, name in only.items() if click.get_current_context().get_parameter_source(name) is ParameterSource.COMMANDLINE
    ]
    if given and not detect:
        raise click.UsageError(f"{given[0]} belongs to --detect")
    from ema_tools.data.actuator import read_actuator
    from ema_tools.design import next_experiment as following
    from ema_tools.plant.native import CHANNELS
    from ema_tools.results.provenance import provenance
    from ema_tools.tasks.simulate import noise_of
    from ema_tools.words.answers.detection import detection
    from ema_tools.words.answers.experiment import experiment
    from ema_tools.words.terminal.next_experiment import print_detection, print_next

    writable(json_path=json_path, force=force, inputs=(actuator,))
    model = read_actuator(actuator)
    chosen = tuple(filter(None, (name.strip() for name in channels.split(",")))) if channels else CHANNELS
    if first is None:
        from ema_tools.design import detection as seeing
        from ema_tools.fit.detection import ShiftTest

        with progress("simulating", 100) as bar:
            seen = seeing.detection(
                model,
                ShiftTest(false_alarm, power, runs),
                present,
                chosen,
                noise_of(noise),
                seeing.scatter_given(scatter),
                following.limits_given(limit),
                also,
                lambda share, text: bar.update(100.0 * share, text),
            )
        told = detection(seen, provenance(command_line(), actuator=model.name))
        save(json_path, told, force)
        print_detection(output(), told)
        return
    effects = following.check_effects((first, *others))
    values = following.sizes_of(settings)
    with progress("simulating", 100) as bar:
        found = following.next_experiment(
            model,
            effects,
            chosen,
            values,
            noise_of(noise),
            following.limits_given(limit),
            also,
            lambda share, text: bar.update(100.0 * share, text),
        )
    result = experiment(found, provenance(command_line(), actuator=model.name))
    save(json_path, result, force)
    print_next(output(), result)


@cli.command(cls=TakesHealthy, short_help="Write what firmware compiles in or reads from flash.")
@click.argument("actuator")
@click.option(
    "-o",
    "--output",
    "out",
    metavar="FILE.h|FILE.c",
    help="The file to write: a header with static const ema_actuator_t EMA_ACTUATOR, or a C source with one constant and its header FILE.h.",
)
@click.option("--flat", metavar="FILE.txt", help="Write section.field = value lines there too, for the host program.")
@click.option(
    "--signatures",
    metavar="FILE.h",
    help="Write the table for the onboard diagnosis there too: static const ema_signatures_t EMA_SIGNATURES.",
)
@healthy_option("Healthy records of the ground test; two or more for a table of signatures.")
@click.option(
    "--signals", metavar="NAME,...", help="Signals of the table; the rod position and the current, where they are recorded, unless told."
)
@click.option("--image", metavar="FILE.bin", help="Write the binary image of the unit there, which firmware reads in flash.")
@click.option("--table", metavar="FILE.h", help="The image's table of signatures, from a header that --signatures wrote.")
@click.option("--beside", metavar="FILE.bin", help="An image whose units the new one holds, too; one of the same name is replaced.")
@click.option("--name", metavar="NAME", help="Name of the unit in the image; the actuator's own unless told.")
@json_option
def export(
    actuator: str,
    out: str | None,
    flat: str | None,
    signatures: str | None,
    healthy: tuple[str, ...],
    signals: str | None,
    image: str | None,
    table: str | None,
    beside: str | None,
    name: str | None,
    json_path: str | None,
    force: bool,
) -> None:
    """Write ACTUATOR as the configuration that firmware compiles in, or as the image that it reads in flash."""
    from ema_tools.base.files import write_bytes, write_text
    from ema_tools.data.actuator import read_actuator
    from ema_tools.data.any_record import record_files
    from ema_tools.data.records import read_record
    from ema_tools.plant.signatures_header import read_signatures, signatures_in
    from ema_tools.results.files import ExportResult
    from ema_tools.tasks import export as work
    from ema_tools.tasks import image as images
    from ema_tools.tasks import signature_table as onboard
    from ema_tools.tasks.onboard_search import search_warnings

    if not out and not image:
        raise click.UsageError("Missing option '-o' / '--output', or --image FILE.bin.")
    if not signatures and not image and (healthy or signals):
        raise click.UsageError("--healthy and --signals belong to --signatures FILE.h, or to --image FILE.bin")
    if not image and (table or beside or name):
        raise click.UsageError("--table, --beside and --name belong to --image FILE.bin")
    if table and (signatures or healthy or signals):
        raise click.UsageError("--table takes the place of --signatures and its records: give one of the two")
    healthy = record_files(healthy)
    read = (actuator, *healthy, *filter(None, [table, beside]))
    header = str(Path(out).with_suffix(".h")) if out and out.endswith(".c") else out
    source = out if out != header else None
    writable(source, header, flat, signatures, image, json_path=json_path, force=force, inputs=read)
    model = read_actuator(actuator)
    work.check_for_firmware(model)
    made = None
    if signatures or healthy or signals:
        records = [read_record(path, model) for path in healthy]
        made = onboard.signatures(model, records, onboard.signals_of(records, signals))
    text = work.signatures_text(made) if made else None
    units: list[images.Unit] = []
    if image:
        flown = signatures_in(text, Path(image)) if text else read_signatures(table) if table else None
        if flown:
            images.check_table(flown, work.fingerprint(model), table or image)
        units = images.joined(images.read_image(beside) if beside else [], images.unit_of(model, flown, name))
    data = images.image_bytes(units) if image else b""
    if source and header:
        write_text(source, work.source_text(model, Path(header).name), force)
        write_text(header, work.declaration_text(model), force)
    elif header:
        write_text(header, work.header_text(model), force)
    if flat:
        write_text(flat, work.flat_text(model), force)
    if signatures and text:
        write_text(signatures, text, force)
    if image:
        write_bytes(image, data, force)
    summary = made.summary() if made is not None else None
    warned = search_warnings(model)
    found = ExportResult(
        "export",
        actuator,
        header,
        flat,
        model.active_effects,
        signatures if made else None,
        summary,
        warned or None,
        images.entry(image, data, units) if image else None,
        source,
    )
    save(json_path, found, force)
    _warn_of_search(actuator, warned)
    if made and made.warning:
        complain(made.warning)
    told = [f"{path} written" for path in (source, header, flat) if path]
    if signatures and made:
        told.append(f"{signatures} written: {2 * made.numbers / 1024:.1f} KiB of signatures in {', '.join(made.signals)}")
    if image:
        told.append(f"{image} written: {len(data) / 1024:.1f} KiB, {', '.join(f'{unit.name} {unit.identity:08x}' for unit in units)}")
    output().print(", ".join(told), highlight=False)


@cli.command(short_help="Show results that firmware packed.")
@click.argument("file")
@json_option
def telemetry(file: str, json_path: str | None, force: bool) -> None:
    """Show the results that firmware packed into FILE, one packet behind the other."""
    from ema_tools.tasks.telemetry import telemetry as work
    from ema_tools.words.terminal.telemetry import print_packets

    writable(json_path=json_path, force=force, inputs=(file,))
    found = work(file)
    save(json_path, found, force)
    print_packets(output(), found)


@cli.command(name="map", short_help="Show friction against speed, from steady runs.")
@click.argument("actuator")
@click.argument("records", nargs=-1, required=True, metavar="REC...")
@click.option("--report", "page", metavar="FILE.html", help="Write the page with the picture there.")
@pictures_option
@json_option
def map_command(
    actuator: str, records: tuple[str, ...], page: str | None, pictures: str | None, json_path: str | None, force: bool
) -> None:
    """Friction of ACTUATOR against speed, from runs at constant speed in any REC, both directions.

    REC takes files, patterns and folders. The model's friction stands beside it; no controller needs to be known.
    """
    from ema_tools.compare.friction_map import friction_map as work
    from ema_tools.data.actuator import read_actuator
    from ema_tools.data.any_record import read_any_record, record_files
    from ema_tools.results.provenance import provenance
    from ema_tools.words.answers.friction_map import friction_map
    from ema_tools.words.terminal.friction_map import print_map
    from ema_tools.words.terminal.next_step import say_next

    records = record_files(records)
    writable(page, *picture_files(pictures, "map", records[0]), json_path=json_path, force=force, inputs=(actuator, *records))
    model = read_actuator(actuator, complete=False)
    found = work(model, [read_any_record(path, model) for path in records])
    origin = provenance(command_line(), actuator=model.name, records=_few([one.file for one in found.records]))
    result = friction_map(found, model.name, origin)
    save(json_path, result, force)
    _page(page, result, force)
    print_map(output(), result)
    say_next(output(), result)
    _written(page)
    draw(pictures, result, records[0], force)


@cli.command(short_help="Make one page of several results.")
@click.argument("results", nargs=-1, required=True, metavar="RESULT.json...")
@click.option("-o", "--output", "out", required=True, metavar="FILE.html", help="The page to write.")
@pictures_option
@json_option
def report(results: tuple[str, ...], out: str, pictures: str | None, json_path: str | None, force: bool) -> None:
    """Make a page of results that identify, compare, diagnose, add or map wrote with --json.

    Several results of a unit are drawn over their dates, which stand in the names of records or result files (such as 2026-03-31); without, in the order given.
    """
    from ema_tools.results.files import ReportResult
    from ema_tools.words.answers.over_dates import over_dates
    from ema_tools.words.page import write_report
    from ema_tools.words.page.results import read_result
    from ema_tools.words.plots import targets, write_pictures

    drawn = [target for result in results if pictures for target in targets(Path(pictures), Path(result).stem)]
    writable(out, *map(str, drawn), json_path=json_path, force=force, inputs=results)
    write_report([Path(result) for result in results], Path(out), command_line(), force, over_dates)
    for result in results if pictures else ():
        name = Path(result).stem
        say_drawn(pictures or "", name, write_pictures(read_result(Path(result)), Path(pictures or ""), name, force))
    save(json_path, ReportResult("report", results, out), force)
    output().print(f"{out} written", highlight=False)


@cli.command(name="demo", short_help="Find a hidden effect and two faults in shipped records.")
@click.option("-o", "--output", "folder", metavar="DIR", help="Folder of results and page; beside the libraries when absent.")
@click.option("--paper", is_flag=True, help="The paper's cases alone, with the curves and surfaces that a paper shows: DIR/paper.html.")
@json_option
def demo_command(folder: str | None, paper: bool, json_path: str | None, force: bool) -> None:
    """Identify the shipped recordings and make their page; results of an earlier demo are replaced."""
    from ema_tools.base.files import keep_apart
    from ema_tools.cli import demo as work
    from ema_tools.cli import paper as paper_work
    from ema_tools.results.files import DemoResult

    target = Path(folder) if folder else work.output_folder()
    chosen = paper_work if paper else work
    keep_apart([*chosen.written(target), *filter(None, (json_path,))])
    writable(json_path=json_path, force=force, made=target)
    page = chosen.run(output(), target)
    save(json_path, DemoResult("demo", str(page), tuple(sorted(path.name for path in page.parent.glob("*.json")))), force)


cli.add_command(loop)
cli.add_command(watch)
cli.add_command(fleet)
cli.add_command(import_group)


@cli.command()
@click.argument("effect", required=False)
@json_option
def effects(effect: str | None, json_path: str | None, force: bool) -> None:
    """Show the library of physical effects, or one EFFECT."""
    from ema_tools.library.definitions import load_definitions
    from ema_tools.tasks import effects as work
    from ema_tools.words.answers.effects import effects as described
    from ema_tools.words.terminal.effects import print_all, print_one

    writable(json_path=json_path, force=force)
    rows = [work.find_effect(effect)] if effect else list(load_definitions().effects)
    found = described(rows)
    save(json_path, found, force)
    if effect:
        print_one(output(), found.effects[0])
    else:
        print_all(output(), found)


def main() -> None:
    """Entry point: runs the command line and ends the process with its exit code."""
    from ema_tools.base.files import show_any_name

    if sys.stderr is None:
        sys.stderr = io.StringIO()  # nobody listens
    if sys.stdout is None:
        complain("standard output: is closed: send it to a file or to /dev/null")
        sys.exit(1)
    show_any_name(sys.stdout)
    try:
        # the code with which a command left, where it did
        code = cli(prog_name="ema", standalone_mode=False)
        sys.stdout.flush()
    except (InputError, MissingSignal, LibraryError) as error:
        complain(str(error))
        sys.exit(1)
    except click.exceptions.Abort:
        complain("interrupted")
        sys.exit(130)
    except click.ClickException as error:
        error.show()
        sys.exit(2)
    except BrokenPipeError:
        _drop_output()
        sys.exit(0)
    except OSError as error:
        from ema_tools.base.files import reason

        _drop_output()
        complain(f"{error.filename or 'standard output'}: {reason(error)}: make room or send it elsewhere")
        sys.exit(1)
    if code:
        sys.exit(code)


def _drop_output() -> None:
    """Give up what standard output did not take, so that the end of the process does not complain about it again."""
    with contextlib.suppress(OSError):
        sys.stdout.close()
