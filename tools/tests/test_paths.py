"""Commands inside of sentences name the files that were given."""

from __future__ import annotations

import pytest

from ema_tools.words.sentences.paths import with_paths


@pytest.mark.parametrize(
    ("text", "healthy", "said"),
    [
        ("ema add ACTUATOR x --fit REC -o NEW.toml", (), "ema add 'a b.toml' x --fit r.csv -o NEW.toml"),
        (
            "ema add ACTUATOR x --fit REC --healthy REC ... -o",
            ("1.csv", "2 3.csv"),
            "ema add 'a b.toml' x --fit r.csv --healthy 1.csv '2 3.csv' -o",
        ),
        ("--healthy REC ... would tell", (), "--healthy REC ... would tell"),
        ("RECORD and ACTUATORS stay, REC. too", (), "RECORD and ACTUATORS stay, REC. too"),
    ],
)
def test_general_words_become_paths(text: str, healthy: tuple[str, ...], said: str) -> None:
    assert with_paths(text, "a b.toml", ["r.csv"], healthy) == said
