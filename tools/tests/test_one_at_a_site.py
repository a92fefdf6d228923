"""Sites at which one effect acts: the general case takes the place of the special one that stands, and two of a site are refused where a user states them."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.hidden.trials import Trial, perform
from ema_tools.base.errors import InputError
from ema_tools.data.actuator import actuator_of, read_actuator
from ema_tools.library.one_at_a_site import acting
from ema_tools.tasks.simulate import with_settings

KNOWN = read_actuator("reference")


def test_a_play_takes_the_place_of_the_contact_that_yields() -> None:
    yields = KNOWN.changed({"effects.presliding.stretch_rad": 0.002})
    assert acting("PRESLIDING", yields.values) == ("presliding",)
    played = yields.changed({"effects.elastic_backlash.gap_mm": 0.1})
    assert acting("PRESLIDING", played.values) == ("elastic_backlash",)
    # not the other way round: a contact that yields is less than a play
    both = played.changed({"effects.presliding.stretch_rad": 0.002})
    assert len(acting("PRESLIDING", both.values)) == 2


def test_a_user_who_states_two_is_told() -> None:
    with pytest.raises(InputError, match="presliding and elastic_backlash are both the contact that carries dry friction"):
        with_settings(KNOWN, ["presliding.stretch_rad=0.002", "elastic_backlash.gap_mm=0.1"])


def test_a_file_that_has_two_is_refused(tmp_path: Path) -> None:
    text = KNOWN.changed({"effects.presliding.stretch_rad": 0.002}).written_text()
    with pytest.raises(InputError, match=r"two.toml: \[effects\]: presliding and elastic_backlash are both"):
        actuator_of(f"{text}\n[effects.elastic_backlash]\ngap_mm = 0.1\ncontact_mm = 0.1\n", "two.toml")


@pytest.mark.release
def test_a_play_is_named_on_a_unit_whose_contacts_always_yielded() -> None:
    """What the healthy runs have at the contact stands in the model: the play was never tried there, and "presliding" of half a turn was accepted."""
    row = perform(Trial("half", ("elastic_backlash",), "medium", "chirp", 3))
    assert row["accepted"] == ["elastic_backlash"]
    assert row["error"]["after"] < 1.05 * row["error"]["floor"]
