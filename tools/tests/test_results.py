"""The codec: every result type survives the way to a file and back, and what is wrong in a file is named."""

from __future__ import annotations

import json
import math
from dataclasses import MISSING, dataclass, field, fields, is_dataclass, replace
from types import NoneType
from typing import Any, Literal, get_args, get_origin, get_type_hints

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchmarks.frozen import read_frozen
from ema_tools.base.errors import InputError
from ema_tools.results.addition import Addition
from ema_tools.results.codec import FORMAT, SPARE, Series, _choices, _rows, from_json, to_json
from ema_tools.results.comparison import BalanceErrorEntry, ChannelErrorEntry, ComparisonResult
from ema_tools.results.diagnosis import DiagnosisByBalanceResult, DiagnosisResult
from ema_tools.results.identification import EstimateEntry, IdentificationResult, NotIdentified
from ema_tools.results.parts import CurvesEntry, EffectEntry, ErrorsEntry, WeightedErrors
from ema_tools.results.reading import Result, kind_of, read_result, result_of

TYPES = get_args(Result)
_NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
_TEXTS = st.text(max_size=8)


def any_of(kind: Any) -> st.SearchStrategy[Any]:
    """Values of a type as the codec knows it."""
    choices = _choices(kind)
    if len(choices) > 1:
        return st.one_of(*map(any_of, choices))
    if kind is NoneType:
        return st.none()
    if is_dataclass(kind):
        assert isinstance(kind, type)
        hints = get_type_hints(kind)
        return st.builds(kind, **{one.name: any_of(hints[one.name]) for one in fields(kind)})
    origin, inner = get_origin(kind), get_args(kind)
    if origin is Literal:
        return st.sampled_from(inner)
    if origin is dict:
        return st.dictionaries(_TEXTS, any_of(inner[1]), max_size=2)
    if origin is tuple:
        return st.lists(any_of(inner[0]), max_size=2).map(tuple) if inner[-1] is Ellipsis else st.tuples(*map(any_of, inner))
    return {float: _NUMBERS, int: st.integers(0, 2**53), str: _TEXTS, bool: st.booleans()}[kind]


@pytest.mark.parametrize("kind", TYPES, ids=lambda kind: kind.__name__)
@settings(max_examples=8, deadline=None, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_every_result_survives_the_way_to_a_file_and_back(kind: type, data: st.DataObject) -> None:
    result = data.draw(any_of(kind))
    text = json.dumps(to_json(result), allow_nan=False)
    assert from_json(json.loads(text), kind, "r.json") == result
    again = json.loads(text)
    assert again["format"] == FORMAT and next(iter(again)) == "format"


def _every(kind: Any, seen: set[type]) -> set[type]:
    """The dataclasses that a type reaches."""
    for one in _choices(kind):
        if is_dataclass(one):
            assert isinstance(one, type)
            if one not in seen:
                seen.add(one)
                for row in _rows(one):
                    _every(row.kind, seen)
        else:
            for inner in get_args(one):
                if inner is not Ellipsis and get_origin(one) is not Literal:
                    _every(inner, seen)
    return seen


def test_every_field_that_is_left_out_where_absent_may_be_absent() -> None:
    for kind in (one for result in TYPES for one in _every(result, set())):
        assert kind.__doc__ and not kind.__doc__.startswith(f"{kind.__name__}("), kind
        for one, row in zip(fields(kind), _rows(kind), strict=True):
            assert not row.spare or (one.default is None and NoneType in _choices(row.kind)), (kind, row.name)
            assert (one.default is MISSING and one.default_factory is MISSING) == row.required


COMPARED = ComparisonResult(
    name="today.csv",
    channels={"position_mm": ChannelErrorEntry(0.1, 5.0, "mm")},
    balances={"mechanical": BalanceErrorEntry(0.01, 4.0, "Nm")},
)
IDENTIFIED = IdentificationResult(
    csj_Nm=EstimateEntry(0.3, 1e-4, 117.4, (0.297, 0.303), 0.138),
    blk_mm=NotIdentified(None, None, None, 0.0, "zero"),
    objective_before_mm2s=0.6,
    objective_after_mm2s=2e-4,
    evaluations=7,
)


def test_a_number_that_is_not_finite_is_null_where_it_may_be_absent_and_refused_elsewhere() -> None:
    vague = replace(COMPARED, channels={"position_mm": ChannelErrorEntry(0.1, math.nan)})
    assert to_json(vague)["channels"]["position_mm"]["relative_percent"] is None
    with pytest.raises(InputError, match=r"^channels\.position_mm\.rmse: inf cannot be written"):
        to_json(replace(COMPARED, channels={"position_mm": ChannelErrorEntry(math.inf, 1.0)}))
    vague_effect = EffectEntry(name="x", score=1.0, limit=2.0, accepted=True, parameters={"ratio": math.nan})
    with pytest.raises(InputError, match=r"^effects\[0\]\.parameters\.ratio: nan"):
        to_json(DiagnosisResult(verdict="missing", error=WeightedErrors(3.0, 1.0), effects=(vague_effect,)))
    with pytest.raises(TypeError, match="None where"):
        to_json(replace(COMPARED, sentence=None))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("colour", "red", "field colour is unknown to this ema"),
        ("channels.position_mm.colour", 1, "field channels.position_mm.colour is unknown to this ema"),
        ("channels.position_mm.rmse", "a", "field channels.position_mm.rmse is not a number"),
        ("channels.position_mm.rmse", True, "field channels.position_mm.rmse is not a number"),
        ("channels.position_mm.rmse", None, "field channels.position_mm.rmse is missing"),
        ("channels.position_mm.rmse", math.nan, "field channels.position_mm.rmse is not finite"),
        ("channels.position_mm.rmse", ..., "field channels.position_mm.rmse is missing"),
        ("channels.position_mm.unit", 3, "field channels.position_mm.unit is not a text"),
        ("channels.position_mm", [], "field channels.position_mm is not an object"),
        ("channels", [], "field channels is not an object"),
        ("where", {}, "field where is not a list of objects"),
        ("where", [1], "field where[0] is not an object"),
        ("unlocated_event_steps", 1.5, "field unlocated_event_steps is not a whole number"),
        (
            "curves",
            {"period_s": 1.0, "measured": {"position_mm": [0.0, "a"]}},
            "field curves.measured.position_mm is not a list of numbers",
        ),
        ("curves", {"period_s": 1.0, "measured": {"position_mm": [0.0, None]}}, "field curves.measured.position_mm is not finite at row 2"),
        ("curves", {"period_s": 1.0, "measured": {"position_mm": [[0.0]]}}, "field curves.measured.position_mm is not a list of numbers"),
        ("format", "1", "field format is not a whole number"),
    ],
)
def test_what_is_wrong_in_a_file_is_named(path: str, value: Any, said: str) -> None:
    data = json.loads(json.dumps(to_json(COMPARED)))
    table = data
    *outer, last = path.split(".")
    for key in outer:
        table = table[key]
    if value is ...:
        del table[last]
    else:
        table[last] = value
    with pytest.raises(InputError) as caught:
        result_of(data, "c.json")
    assert str(caught.value).startswith(f"c.json: {said}") and "\n" not in str(caught.value)


def test_words_that_are_no_choice_and_wrong_truths_are_named() -> None:
    data = to_json(IDENTIFIED)
    for change, said in (
        ({"verdict": "perhaps"}, "verdict is none of healthy, fault, undecided"),
        ({"adequate": 1}, "adequate is neither true nor false"),
    ):
        with pytest.raises(InputError, match=f"i.json: field {said}"):
            result_of({**data, **change}, "i.json")
    with pytest.raises(InputError, match=r"field correlations\[0\]\.values is not a list of 2 texts"):
        added = to_json(Addition(effect="x", actuator="new.toml", error=ErrorsEntry(None, None), parameters={}))
        result_of({**added, "correlations": [{"values": ["a"], "correlation": 1.0}]}, "a.json")


def test_older_files_read_and_newer_formats_are_refused_in_one_sentence() -> None:
    data = to_json(COMPARED)
    del data["format"], data["unlocated_event_steps"], data["where"]
    assert result_of(data, "c.json") == COMPARED
    with pytest.raises(InputError, match=r"^c\.json: format 2 is newer than this ema, which reads up to 1: "):
        result_of({**data, "format": 2, "whatever": 1}, "c.json")


def test_a_file_is_read_as_what_its_command_writes(tmp_path: Any) -> None:
    path = tmp_path / "i.json"
    path.write_text(json.dumps(to_json(IDENTIFIED)), encoding="utf-8")
    assert read_result(path) == IDENTIFIED
    assert kind_of({"command": "demo", "page": "p"}, "") is not kind_of({"command": "demo"}, "") is IdentificationResult
    assert kind_of({"csj_Nm": {}}, "") is IdentificationResult and kind_of({"balances": {}}, "") is ComparisonResult
    for data in ({"rows": 5}, {"command": ["compare"]}, {"command": "fly"}):
        with pytest.raises(InputError, match=r"x\.json: holds no `command` of ema"):
            kind_of(data, "x.json")


def test_the_value_of_a_union_is_the_type_that_fits() -> None:
    assert isinstance(result_of(to_json(IDENTIFIED), "i.json"), IdentificationResult)
    for error in (ErrorsEntry(2.0, 1.0), WeightedErrors(2.0, 1.0)):
        added = Addition(effect="x", actuator="new.toml", error=error, parameters={})
        read = from_json(to_json(added), Addition, "a.json")
        assert read == added and type(read.error) is type(error)


def test_a_spare_field_is_no_key_where_it_is_none() -> None:
    @dataclass(frozen=True)
    class Small:
        """For the test."""

        kept: float | None = None
        left: float | None = field(default=None, metadata=SPARE)

    assert to_json(Small()) == {"format": FORMAT, "kept": None}
    assert "curves" not in to_json(COMPARED)
    assert Series == tuple[float, ...] and CurvesEntry(period_s=1.0, measured=None).start_s == 0.0  # type: ignore[arg-type]


def _without_long_rows(value: Any) -> Any:
    """A frozen answer with its long rows, which are frozen as three numbers, empty."""
    if isinstance(value, dict):
        return (
            []
            if {"count", "sum", "rms"} <= set(value) <= {"count", "sum", "rms", "words"}
            else {key: _without_long_rows(one) for key, one in value.items()}
        )
    return [_without_long_rows(one) for one in value] if isinstance(value, list) else value


def test_every_frozen_answer_reads_as_its_type_and_is_written_as_it_was() -> None:
    answers = [_without_long_rows(one) for one in read_frozen().values() if "error_line" not in one]
    assert len(answers) > 50
    for data in answers:
        found = result_of(data, "frozen")
        assert isinstance(found, DiagnosisResult | DiagnosisByBalanceResult)
        again = json.loads(json.dumps(to_json(found)))
        assert {key: value for key, value in again.items() if key not in ("format", "provenance", "next", "rivals")} == data
