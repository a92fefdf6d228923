"""Several results of a unit over their dates: which unit and date each has, what is said without dates, and what stands on the page."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

from ema_tools.results.codec import to_json
from ema_tools.results.diagnosis import DiagnosisResult
from ema_tools.results.identification import EstimateEntry, IdentificationResult
from ema_tools.results.parts import EffectEntry, WeightedErrors
from ema_tools.words.answers.over_dates import over_dates
from ema_tools.words.page import write_report
from support import RECORDINGS, run_ema


def identified(record: str, csj_percent: float, **changes: object) -> IdentificationResult:
    """CSJ off by so much, to 1 %; BLK as it was."""
    csj = 0.138 * (1.0 + 0.01 * csj_percent)
    found = IdentificationResult(
        name=record,
        csj_Nm=EstimateEntry(csj, 7e-4, csj_percent, (csj - 0.00138, csj + 0.00138), 0.138, threshold_percent=5.0),
        blk_mm=EstimateEntry(0.033, 1e-4, 0.0, (0.0328, 0.0332), 0.033, threshold_percent=10.0),
        objective_before_mm2s=0.1,
        objective_after_mm2s=1e-4,
        evaluations=9,
        verdict="fault",
        adequate=True,
        provenance={"actuator": "left"},
    )
    return replace(found, **changes)  # type: ignore[arg-type]


def days(count: int) -> list[tuple[Path, IdentificationResult]]:
    return [(Path("a") / f"{day}.json", identified(f"2026-05-{day + 1:02}.csv", 4.0 * max(0, day - 3))) for day in range(count)]


def test_dates_are_those_of_the_records_and_a_drift_is_told() -> None:
    (unit,) = over_dates(days(12))
    assert unit.unit == "left" and unit.dated and unit.days == tuple(float(day) for day in range(12))
    assert unit.trends["csj"].changed and not unit.trends["blk"].changed
    assert unit.thresholds_percent == {"csj": 5.0, "blk": 10.0}
    assert unit.sentence.startswith("left: CSJ has changed by +") and unit.whence == "Dates are from the names of the records."
    # intervals of the values are those of the shifts
    assert unit.rows[0].reading("csj") == pytest.approx((0.0, -1.0, 1.0))


@pytest.mark.parametrize(
    ("files", "whence"),
    [
        (("u/2026-05-01.json", "u/2026-05-03.json"), "Dates are from the names of the result files."),
        (("2026-05-01/x.json", "2026-05-03/x.json"), "Dates are from the names of the folders."),
        (("u/2026-05-01.json", "2026-05-03/x.json"), "Dates are from the names of the result files and the names of the folders."),
    ],
)
def test_a_date_may_stand_in_the_name_of_the_result_or_its_folder(files: tuple[str, ...], whence: str) -> None:
    (unit,) = over_dates([(Path(file), identified(f"r{place}.csv", 1.0)) for place, file in enumerate(files)])
    # a folder with a date is no unit
    assert unit.unit == "left" and unit.dated
    assert unit.whence == whence and unit.days == (0.0, 2.0)


def test_without_a_date_for_each_the_order_stands_and_it_is_said() -> None:
    found = days(6)
    found[2] = (found[2][0], replace(found[2][1], name="third.csv"))
    (unit,) = over_dates(found)
    assert not unit.dated and unit.days == (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    assert "third.csv has no date" in unit.whence and unit.whence.startswith("In the order given")
    assert "since" not in unit.trends["csj"].sentence and "nothing is said of its pace" in unit.trends["csj"].sentence


def test_units_are_folders_or_actuators_and_one_record_is_no_history() -> None:
    folders = [(Path(folder) / f"{day}.json", identified(f"2026-05-0{day}.csv", 1.0)) for folder in ("left", "right") for day in (1, 2)]
    assert [one.unit for one in over_dates(folders)] == ["left", "right"]
    other = [(path, replace(one, provenance={"actuator": "aileron"})) for path, one in days(2)]
    assert [one.unit for one in over_dates([*days(2), *other])] == ["aileron", "left"]
    assert over_dates([(Path("a.json"), identified("today.csv", 1.0)), (Path("b.json"), identified("today.csv", 2.0))]) == ()
    assert over_dates([(path, replace(one, case="A")) for path, one in days(3)]) == ()


def test_diagnoses_count_and_what_the_model_does_not_explain_does_not() -> None:
    fault = EffectEntry(name="csj", score=9.0, limit=1.0, accepted=True, shift_percent=12.0, shift_interval95=(11.0, 13.0))
    diagnosed = DiagnosisResult(
        name="2026-06-01.csv", verdict="missing", error=WeightedErrors(3.0, 1.0), faults={"csj": fault}, provenance={"actuator": "left"}
    )
    unsure = identified("2026-06-02.csv", 40.0, adequate=False, verdict="undecided")
    (unit,) = over_dates([*days(3), (Path("a/d.json"), diagnosed), (Path("a/e.json"), unsure)])
    assert unit.trends["csj"].shift_percent[-1] == 12.0 and len(unit.trends["csj"].days) == 4
    assert unit.rows[-1].reading("csj")[0] == 40.0


def test_the_page_shows_every_reading(tmp_path: Path) -> None:
    files = []
    for path, one in [*days(8), (Path("9.json"), identified("2026-05-20.csv", 30.0, adequate=False, verdict="undecided"))]:
        files.append(tmp_path / path.name)
        files[-1].write_text(json.dumps(to_json(one)), encoding="utf-8")
    write_report(files, tmp_path / "page.html", "ema report", over_dates=over_dates)
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    section = page[page.index('<section id="dates"') : page.index('<section id="result-1"')]
    assert section.count("<svg") == 2 and section.count('<tr><th scope="row">2026-05-') == 9
    # a key for each series that is drawn
    assert re.findall(r'data-show="(\w+)"', section) == ["reading", "open", "healthy", "threshold"] + ["limit"] * ("s-limit" in section) + [
        "since"
    ] * ("s-since" in section) + ["life"] * ("s-life" in section)
    csj = section[section.index("CSJ, static dry friction, days since 2026-05-01") :]
    assert re.search(r'class="dots after s-reading big"[^>]* d="(?:M[\d.]+ [\d.]+h0){8}"', csj) and re.search(
        r'class="dots open s-open big"[^>]* d="M[\d.]+ [\d.]+h0"', csj
    )
    assert (
        csj.index('class="band healthy s-healthy"')
        < csj.index('class="threshold thin s-threshold"')
        < csj.index('class="band after s-reading"')
    )


@pytest.mark.slow
def test_the_command_takes_results_of_two_days(tmp_path: Path) -> None:
    unit = RECORDINGS / "unit"
    for day, record in (("2026-05-01", "sound"), ("2026-06-01", "worn")):
        ran = run_ema("identify", unit / "unit.toml", unit / f"{record}.csv", "--no-guard", "--json", tmp_path / f"{day}.json")
        assert ran.code == 0, ran
    first, second = tmp_path / "2026-05-01.json", tmp_path / "2026-06-01.json"
    assert run_ema("report", first, second, "-o", tmp_path / "page.html").code == 0
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    change = json.loads(second.read_text(encoding="utf-8"))["csj_Nm"]["shift_percent"]
    assert change > 15.0
    assert f"2 results; the last that counts reads CSJ {change:+.1f} %" in page and "days since 2026-05-01" in page
    assert json.loads(first.read_text(encoding="utf-8"))["csj_Nm"]["threshold_percent"] == 5.0
