"""`ema_identify` refuses every bad input of the table with its one line and exit code."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import bad_input
from bad_input import CASES, PAGE, Case
from host_program import PROGRAM, run

pytestmark = [pytest.mark.host, PROGRAM]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.what.replace(" ", "_"))
def test_bad_input(tmp_path: Path, case: Case) -> None:
    for name, content in case.files.items():
        (tmp_path / name).write_bytes(content())
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    answer = run(tmp_path, *case.arguments)
    assert answer.stderr.decode() == case.message + "\n"
    assert answer.returncode == case.exit_code
    if not case.message.startswith("none/new.json"):
        assert answer.stdout == b""
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_the_page_is_made_from_the_table() -> None:
    assert PAGE.read_text(encoding="utf-8") == bad_input.page(), "run: python tools/tests/bad_input.py"


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(edits=st.lists(st.tuples(st.integers(0, 4000), st.binary(min_size=0, max_size=6)), min_size=1, max_size=4))
def test_broken_bytes_are_read_or_refused_in_one_line(tmp_path: Path, edits: list[tuple[int, bytes]]) -> None:
    content = bytearray(bad_input.text(bad_input.rows()))
    for place, put in edits:
        content[place : place + len(put)] = put
    (tmp_path / "rec.csv").write_bytes(content)
    answer = run(tmp_path, "rec.csv")
    message = answer.stderr.decode()
    if answer.returncode == 0:
        assert message == ""
    else:
        assert answer.returncode == 1
        assert answer.stdout == b""
        assert message.startswith("rec.csv: ")
        assert message.count("\n") == 1
