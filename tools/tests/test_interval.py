"""What is stated of an estimate besides its value: the interval counts what moves it from run to run, not sensor noise alone."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from ema_tools.base.interval import interval95
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import Record
from ema_tools.fit.interval import scatter_of
from ema_tools.fit.nuisance import FROM_RUN_TO_RUN
from ema_tools.plant.native import SearchSettings
from ema_tools.tasks.identify import identify
from support import RECORDINGS, REFERENCE, chirp_record, run_ema

NAMES = ("screw.csj_Nm", "screw.blk_mm")
WORN = {"screw.csj_Nm": 0.2, "screw.blk_mm": 0.06}


def on_a_day(deviations: dict[str, float], seed: int) -> Record:
    """The worn actuator with what scatters at so many standard deviations, and sensor noise."""
    worn = reference_actuator().changed(WORN)
    moved = {name: worn[name] * (1.0 + FROM_RUN_TO_RUN[name] * at) for name, at in deviations.items()}
    return chirp_record(worn.changed(moved)).with_noise({"position_mm": 0.002}, seed)


@pytest.mark.parametrize("name", FROM_RUN_TO_RUN)
def test_an_estimate_follows_what_scatters_as_is_said(name: str) -> None:
    """Three standard deviations up and down: the search's own estimates move by six of those that are stated of this one alone."""
    search = SearchSettings(seed=1)
    answers = [identify(reference_actuator(), on_a_day({name: at}, 3), (), search, guarding=False).answer.identified for at in (-3.0, 3.0)]
    seen = [abs(high.estimate - low.estimate) / 6.0 for low, high in zip(*answers, strict=True)]
    stated = scatter_of(reference_actuator().changed(WORN), on_a_day({}, 3), NAMES, {"position_mm": 1.0})
    assert all(one <= 1.1 * stated[value] + 1e-9 for one, value in zip(seen, NAMES, strict=True))
    if name == "screw.csj_Nm":
        assert seen[0] == pytest.approx(stated["screw.csj_Nm"], rel=0.1)


def test_the_interval_holds_the_wear_on_other_days() -> None:
    """Where the standard error of sensor noise alone would hold it on few."""
    random = np.random.default_rng(7)
    held = alone = 0
    for day in range(20):
        record = on_a_day({name: float(random.normal()) for name in FROM_RUN_TO_RUN}, 100 + day)
        found = identify(reference_actuator(), record, (), SearchSettings(seed=1), guarding=False)
        one = found.answer.identified[0]
        low, high = found.interval95(one)
        assert low is not None and high is not None
        held += low <= WORN["screw.csj_Nm"] <= high
        alone += abs(one.estimate - WORN["screw.csj_Nm"]) <= 1.96 * one.std
    assert held >= 17
    assert alone <= 10


def test_nothing_is_stated_of_what_a_record_does_not_determine() -> None:
    assert interval95(1.0, math.nan, 0.1) == (None, None)
    assert interval95(1.0, 0.03, 0.04) == pytest.approx((0.902, 1.098))


@pytest.mark.slow
def test_programs_read_it(tmp_path: Path) -> None:
    ran = run_ema("identify", REFERENCE, RECORDINGS / "case_a_noisy.csv", "--json", tmp_path / "i.json")
    assert ran.code == 0, ran.err
    written = json.loads((tmp_path / "i.json").read_text(encoding="utf-8"))
    for key, true in (("csj_Nm", 0.3), ("blk_mm", 0.04125)):
        low, high = written[key]["interval95"]
        assert low < written[key]["estimate"] < high
        assert low <= true <= high
        assert high - low > 2.0 * 1.96 * written[key]["std"]
