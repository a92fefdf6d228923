"""Pictures as SVG and PNG: what each kind of result gives, that a picture holds what the result says, and that nothing is written over."""

from __future__ import annotations

import io
import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
from matplotlib import image

from diagnosis_results import diagnosis
from ema_tools.base.errors import InputError
from ema_tools.results.friction_map import MapPointEntry, MapResult
from ema_tools.words.page.results import Result, parse_result, shown
from ema_tools.words.plots import ENDINGS, style, targets, write_pictures
from ema_tools.words.plots.signals import thinned
from report_results import compared, identified
from support import RECORDINGS, REFERENCE, complaint, run_ema

_SVG = "{http://www.w3.org/2000/svg}"
_SHAPE = {
    "csj_Nm": {"value": [0.2, 0.28, 0.3, 0.32, 0.4], "objective_mm2s": [0.2, 0.01, 2.5e-4, 0.01, 0.3], "limit_mm2s": 4e-4},
    "blk_mm": {"value": [0.02, 0.04, 0.04125, 0.06], "objective_mm2s": [3e-3, 3e-4, 2.5e-4, 4e-3], "limit_mm2s": 4e-4},
    "map": {
        "csj_Nm": [0.1, 0.3, 0.4],
        "blk_mm": [0.02, 0.04, 0.06],
        "objective_mm2s": [[0.7, 0.1, 0.3], [0.6, 2.5e-4, 0.2], [0.8, 0.1, 0.4]],
    },
    "path": {"csj_Nm": [0.138, 0.25, 0.3], "blk_mm": [0.033, 0.05, 0.04125]},
    "path_cost_mm2s": [0.674, 0.1, 2.5e-4],
}


def result_of(data: dict[str, Any]) -> Result:
    return parse_result(data, "today.json", "today")


def mapped() -> Result:
    points = tuple(
        MapPointEntry(speed, 0.1 * math.copysign(1.0, speed), 0.09, 0.11, (0.09, 0.11), 0.1, 3, 2.0, ("a.csv",))
        for speed in (-20.0, -5.0, 5.0, 20.0)
    )
    return shown(MapResult("map", "a.csv", "mine", ("a.csv",), "Friction is 0.1 Nm.", 12, points, ()), "m.json", "m")


RESULTS = {
    "missing": (lambda: result_of(diagnosis("missing")), {"signals", "where", "candidates", "ladder"}),
    "unknown": (lambda: result_of(diagnosis("unknown")), {"signals", "where", "candidates", "ladder"}),
    "healthy": (lambda: result_of(diagnosis("healthy")), {"signals", "where", "ladder"}),
    "identified": (lambda: result_of(identified(shape=_SHAPE)), {"signals", "objective", "search"}),
    "compared": (lambda: result_of(compared()), {"signals", "where", "balances"}),
    "mapped": (mapped, {"friction"}),
}  # fmt: skip


def words_of(path: Path) -> str:
    return " | ".join("".join(one.itertext()) for one in ElementTree.parse(path).iter(f"{_SVG}text"))


def colours_of(path: Path) -> set[str]:
    text = path.read_text(encoding="utf-8")
    return {colour for colour in (style.MEASURED, style.BEFORE, style.AFTER, style.NOISE, style.OTHER) if colour in text}


# Matplotlib needs a second for two pictures.
@pytest.mark.parametrize("kind", [pytest.param(kind, marks=() if kind in ("compared", "mapped") else pytest.mark.slow) for kind in RESULTS])
def test_each_result_gives_its_pictures_in_both_forms(kind: str, tmp_path: Path) -> None:
    make, kinds = RESULTS[kind]
    written = write_pictures(make(), tmp_path, "x")
    assert (
        {path.name for path in written}
        == {f"x_{one}.{ending}" for one in kinds for ending in ENDINGS}
        == {path.name for path in tmp_path.iterdir()}
    )
    assert set(written) <= set(targets(tmp_path, "x"))
    for path in written:
        if path.suffix == ".png":
            pixels = image.imread(path)[..., :3]
            height, width = pixels.shape[:2]
            assert width == 1500 and 250 < height < 3000
            # light, with ink on it: neither empty nor filled
            dark = float(np.mean(np.min(pixels, axis=2) < 0.9))
            assert np.all(pixels[-1, 0] == 1.0) and 0.01 < dark < 0.7, path.name
            assert 20_000 < path.stat().st_size < 1_500_000, path.name
        else:
            # text stays text, and names what was recorded and units
            assert len(words_of(path)) > 60 and path.stat().st_size < 1_500_000, path.name
            assert "<image" not in path.read_text(encoding="utf-8") or "friction" in path.name


@pytest.mark.slow
def test_pictures_say_what_the_result_says(tmp_path: Path) -> None:
    write_pictures(result_of(diagnosis("missing")), tmp_path, "d")
    ladder = words_of(tmp_path / "d_ladder.svg")
    for told in (
        "as given",
        "48.0",
        "+ Stribeck friction",
        "4.00",
        "+ friction (CSJ)",
        "0.860",
        "noise level 0.870",
        "validation record",
        "times the sensor noise",
    ):
        assert told in ladder, told
    signals = words_of(tmp_path / "d_signals.svg")
    assert "The model does not hold. Stribeck friction is missing" in " ".join(signals.replace(" | ", " ").split())
    for told in (
        "Rod position, mm",
        "Motor current, A",
        "Motor voltage, V",
        "measured minus simulated, µm: rms",
        "with Stribeck friction",
        "time, s",
    ):
        assert told in signals, told
    assert colours_of(tmp_path / "d_signals.svg") >= {style.MEASURED, style.BEFORE, style.AFTER}
    where = words_of(tmp_path / "d_where.svg")
    assert "Mechanics" in where and "Over speed, rad/s" in where
    candidates = words_of(tmp_path / "d_candidates.svg")
    assert candidates.index("Stribeck friction") < candidates.index("Spring load") and "not named" in candidates

    write_pictures(result_of(identified(shape=_SHAPE)), tmp_path, "i")
    objective = words_of(tmp_path / "i_objective.svg")
    for told in (
        "0.3000 Nm",
        "CSJ, static dry friction, Nm",
        "BLK, backlash at the rod, mm",
        "healthy",
        "found",
        "Integrated squared error, mm² s",
    ):
        assert told in objective, told
    assert "Model run" in words_of(tmp_path / "i_search.svg")

    write_pictures(result_of(compared()), tmp_path, "c")
    assert "4.08 %" in words_of(tmp_path / "c_balances.svg") and "rod position: speed 0 to 5 mm/s" in words_of(tmp_path / "c_where.svg")


@pytest.mark.slow
def test_the_ladder_stands_at_its_values(tmp_path: Path) -> None:
    write_pictures(result_of(diagnosis("missing")), tmp_path, "d")
    pixels = image.imread(tmp_path / "d_ladder.png")[..., :3]
    blue = np.array(matplotlib.colors.to_rgb(style.AFTER))
    rows, columns = np.nonzero(np.all(np.abs(pixels - blue) < 0.03, axis=2))
    # the dots' middles, each step lower and further left than the one before; the key of the legend stands beneath
    plotted = rows < 0.8 * pixels.shape[0]
    gaps = np.flatnonzero(np.diff(np.unique(rows[plotted])) > 5)
    bands = np.split(np.unique(rows[plotted]), gaps + 1)
    middles = [float(np.mean(columns[plotted & np.isin(rows, band)])) for band in bands]
    assert len(middles) == 4 and middles == sorted(middles, reverse=True)
    # logarithmic: the steps' distances are those of the logarithms
    first, *_, last = middles
    share = (first - middles[1]) / (first - last)
    assert share == pytest.approx(math.log(48.0 / 8.0) / math.log(48.0 / 0.86), abs=0.01)


def test_the_same_picture_again_is_the_same_file_and_settings_are_left_alone(tmp_path: Path) -> None:
    before = dict(matplotlib.rcParams)
    write_pictures(mapped(), tmp_path / "a", "m")
    write_pictures(mapped(), tmp_path / "b", "m")
    assert dict(matplotlib.rcParams) == before
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes(), path.name
    with pytest.raises(InputError, match="exists already"):
        write_pictures(mapped(), tmp_path / "a", "m")


def test_a_thinned_curve_keeps_its_extremes() -> None:
    time = np.linspace(0.0, 10.0, 10_001)
    values = np.sin(5.0 * time)
    values[4321] = 7.0
    short_time, short = thinned(time, values)
    assert short.size < 1500 and short.max() == 7.0 and short.min() == values.min()
    assert np.all(np.diff(short_time) > 0.0) and short_time[0] == 0.0 and short_time[-1] == 10.0


def test_a_result_without_anything_to_draw_is_told(tmp_path: Path) -> None:
    bare = {key: value for key, value in identified().items() if key not in ("curves", "search", "provenance")}
    with pytest.raises(InputError, match="nothing to draw"):
        write_pictures(result_of(bare), tmp_path, "x")


@pytest.mark.slow
def test_commands_write_their_pictures(tmp_path: Path) -> None:
    record, folder = RECORDINGS / "case_b.csv", tmp_path / "pictures"
    ran = run_ema("identify", REFERENCE, record, "--no-guard", "--pictures", folder)
    assert ran.code == 0 and "case_b_identify_*: signals, objective, search, each as .svg and .png" in ran.out
    assert run_ema("compare", REFERENCE, record, "--pictures", folder).code == 0
    names = {path.name for path in folder.iterdir()}
    assert {
        f"case_b_{one}.{ending}"
        for one in ("identify_signals", "identify_objective", "compare_signals", "compare_balances")
        for ending in ENDINGS
    } <= names
    with io.BytesIO((folder / "case_b_compare_signals.png").read_bytes()) as stream:
        assert image.imread(stream).shape[1] == 1500
    # it is said before the work
    assert "case_b_compare_signals.svg: exists already" in complaint(run_ema("compare", REFERENCE, record, "--pictures", folder))
