"""Measured against simulated: the numbers, where they come from, and what is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ema_tools.base.errors import InputError
from ema_tools.compare.comparison import compare
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import read_record
from ema_tools.results.codec import to_json
from ema_tools.words.answers.comparison import comparison
from ema_tools.words.sentences.comparison import sentence
from support import RECORDINGS, chirp_record


def test_a_record_too_short_for_any_filter_is_one_line() -> None:
    full = chirp_record()
    record = full.with_columns({column: full.recorded(column)[:199] for column in full.present})
    with pytest.raises(InputError, match=r"simulated: 199 rows, 0.199 s, too few for any filter: record 0.2 s or more"):
        compare(reference_actuator(), record)


def test_channels_are_measured_minus_simulated() -> None:
    record = chirp_record()
    found = compare(reference_actuator(), replace(record, current_A=1.01 * record.current_A))
    assert found.channels["current_A"].relative_percent == pytest.approx(1.0 / 1.01, rel=1e-6)
    assert found.channels["current_A"].rmse == pytest.approx(0.01 * np.sqrt(np.mean(record.current_A[50:-50] ** 2)), rel=1e-6)
    assert found.channels["position_mm"].rmse == 0.0


def test_own_record_accuses_nobody() -> None:
    found = compare(reference_actuator(), chirp_record())
    assert sentence(found).startswith("The model explains simulated as far as sensor noise and method can tell")
    noisy = chirp_record().with_noise({"position_mm": 0.005, "motor_position_mm": 0.005, "current_A": 0.03}, 1)
    found = compare(reference_actuator(), noisy)
    assert sentence(found).startswith("The model explains simulated as far as sensor noise and method can tell")
    assert found.balances["kinematic"].noise_rms == pytest.approx(0.005 * np.sqrt(2.0), rel=0.3)


def test_independent_healthy_record_accuses_nobody() -> None:
    record = read_record(RECORDINGS / "healthy.csv", reference_actuator())
    found = compare(reference_actuator(), record)
    assert sentence(found).startswith("The model explains healthy.csv")
    assert found.channels["position_mm"].rmse < 1e-6


@pytest.mark.parametrize(
    ("changes", "accused"),
    [
        ({"screw.csj_Nm": 0.2}, "mechanical"),
        ({"motor.resistance_ohm": 1.2}, "electrical"),
        ({"screw.blk_mm": 0.066}, "kinematic"),
        ({"control.kp_per_m": 440.0}, "controller"),
    ],
)
def test_changed_machine_is_accused_in_its_own_group(changes: dict[str, float], accused: str) -> None:
    found = compare(reference_actuator(), chirp_record(reference_actuator().changed(changes)))
    assert f"is in the {accused} balance" in sentence(found)
    shares = {place.part: place.share for place in found.where if place.source == "all balances"}
    assert max(shares, key=lambda name: shares[name]) == accused
    assert shares[accused] > 0.99


def test_shares_are_complete_and_sorted() -> None:
    record = read_record(RECORDINGS / "case_a_noisy.csv", reference_actuator())
    found = compare(reference_actuator(), record)
    shares = [place.share for place in found.where]
    assert shares == sorted(shares, reverse=True)
    groups: dict[tuple[str, str], float] = {}
    times: dict[tuple[str, str], float] = {}
    for place in found.where:
        groups[place.source, place.by] = groups.get((place.source, place.by), 0.0) + place.share
        times[place.source, place.by] = times.get((place.source, place.by), 0.0) + (place.time_share or 0.0)
    assert {source for source, _ in groups} == {
        "all balances", "mechanical balance", "electrical balance", "kinematic balance", "controller balance", "rod position", "motor position", "current", "voltage",
    }  # fmt: skip
    assert {by for _, by in groups} == {"", "time", "speed", "position", "current", "direction", "time since reversal", "frequency"}
    for key, total in groups.items():
        assert total == pytest.approx(1.0, abs=1e-9), key
        if key[1] not in ("", "frequency"):
            assert times[key] == pytest.approx(1.0, abs=0.01)


def test_place_of_a_fault_is_found() -> None:
    record = chirp_record()
    bumped = record.current_A + 2.0 * ((record.position_mm > 1.3) & (record.position_mm < 1.5))
    found = compare(reference_actuator(), replace(record, current_A=bumped))
    places = [place for place in found.where if place.source == "current" and place.by == "position"]
    assert places[0].part == "1.17 to 1.93 mm"
    assert places[0].share == pytest.approx(1.0, abs=0.01)
    assert places[0].surprise == max(place.surprise for place in found.where if place.source == "current")


def test_frequency_of_an_error_is_found() -> None:
    record = chirp_record()
    found = compare(reference_actuator(), replace(record, current_A=record.current_A + np.sin(2.0 * np.pi * 12.0 * record.time_s)))
    bands = {place.part: place.share for place in found.where if place.source == "current" and place.by == "frequency"}
    assert bands["8 to 16 Hz"] > 0.99


def test_result_has_the_keys_that_programs_read() -> None:
    record = replace(chirp_record(), voltage_V=None)
    result = to_json(comparison(compare(reference_actuator(), record), {}))
    assert set(result["channels"]) == {"position_mm", "motor_position_mm", "current_A", "speed_mm_s"}
    for channel in result["channels"].values():
        assert {"rmse", "relative_percent"} <= set(channel)
    for name in ("mechanical", "electrical", "kinematic", "controller"):
        assert {"rms", "relative_percent", "reason"} <= set(result["balances"][name])
    assert result["balances"]["electrical"]["reason"] == "voltage_V is not recorded"
    assert result["balances"]["mechanical"]["reason"] is None
    assert {"name", "share_percent"} <= set(result["where"][0])


def test_noise_and_method_are_those_of_the_same_filter() -> None:
    noisy = chirp_record().with_noise({"position_mm": 0.005, "motor_position_mm": 0.005, "current_A": 0.03}, 1)
    balance = compare(reference_actuator(), noisy).balances["mechanical"]
    assert 0.0 < balance.noise_rms < balance.rms
    assert 0.0 < balance.method_rms < balance.rms
    assert balance.rms < 1.5 * np.hypot(balance.noise_rms, balance.method_rms)
    warm = compare(reference_actuator().changed({"screw.csj_Nm": 0.16}), noisy)
    assert "is in the mechanical balance" in sentence(warm)


def test_place_in_the_lead_is_told_only_where_the_rod_passes_it_more_than_once() -> None:
    record = chirp_record(text="chirp:amplitude_mm=8,start_hz=0.1,end_hz=1")
    lead = reference_actuator()["screw.lead_mm"]
    bumped = record.current_A + 1.0 * (np.mod(record.position_mm, lead) > 0.8 * lead)
    found = compare(reference_actuator(), replace(record, current_A=bumped))
    places = [place for place in found.where if place.source == "current" and place.by == "place in the lead"]
    assert places[0].part == "4 to 5 mm" and places[0].share > 0.95
    short = compare(reference_actuator(), chirp_record()).where
    assert not any(place.by == "place in the lead" for place in short)
