"""Commands as the user types them."""

from __future__ import annotations

import numpy as np
import pytest

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.commands import DEFAULTS, make_command
from ema_tools.data.records import read_record
from support import RECORDINGS


def test_reference_chirp() -> None:
    command = make_command("chirp", reference_actuator())
    time_s = 1e-3 * np.arange(10000)
    expected = 2.0 * np.sin(2.0 * np.pi * (0.1 * time_s + (4.0 - 0.1) * time_s**2 / 20.0))
    assert np.max(np.abs(command.samples_mm - expected)) < 1e-9
    assert command.start_mm == 0.0


@pytest.mark.parametrize("kind", list(DEFAULTS))
def test_every_command_starts_at_zero_and_keeps_its_amplitude(kind: str) -> None:
    command = make_command(f"{kind}:amplitude_mm=1.5,duration_s=4", reference_actuator())
    assert command.samples_mm.shape == (4000,)
    assert abs(command.samples_mm[0]) < 1e-12
    # Schroeder phases keep a multisine within twice its share of the amplitude.
    assert 0.7 * 1.5 < np.max(np.abs(command.samples_mm)) < (3.0 if kind == "multisine" else 1.5 + 1e-12)


def test_command_of_a_recording() -> None:
    path = RECORDINGS / "case_a.csv"
    command = make_command(str(path), reference_actuator())
    assert np.array_equal(command.samples_mm, read_record(path).command_mm)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("chrip", r"command chrip: neither a file nor a command \(did you mean chirp\?\)"),
        ("chirp:end=4", r"command chirp: end=4: unknown number \(did you mean end_hz\?\)"),
        ("chirp:end_hz", "command chirp: end_hz: unknown number"),
        ("chirp:end_hz=fast", "command chirp: end_hz=fast: not a number: write for example end_hz=4"),
        ("chirp:end_hz=nan", "command chirp: end_hz=nan: not a finite number"),
        (
            "chirp:end_hz=900",
            "command chirp:.*end_hz=900.*a value is outside its range: frequencies lie between 0 and half the record rate",
        ),
        ("chirp:duration_s=0", "command chirp: duration_s=0: not above zero"),
        ("chirp:duration_s=1e9", "command chirp: duration_s=1e.09: 1000000000000 rows: ask for 1 to 10000000"),
        ("step:share=1", "command step: share=1: unknown number"),
    ],
)
def test_bad_command_is_named_in_one_line(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make_command(text, reference_actuator())


def test_recording_at_another_rate_is_refused() -> None:
    actuator = reference_actuator().changed({"timing.record_every_steps": 2})
    with pytest.raises(InputError, match=r"case_a.csv: time_s: a row every 0.001 s, and the actuator records one every 0.002 s"):
        make_command(str(RECORDINGS / "case_a.csv"), actuator)
