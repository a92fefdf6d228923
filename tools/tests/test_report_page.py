"""The page: what it takes, what it refuses, and that the file is whole."""

from __future__ import annotations

import base64
import json
import re
import xml.etree.ElementTree as ElementTree
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ema_tools.base.errors import InputError
from ema_tools.words.page import figures, write_report
from ema_tools.words.page.curves import pack
from ema_tools.words.page.figure_svg import figure_svg
from ema_tools.words.page.gauges import gauges
from ema_tools.words.page.recorded import SLOPE_ROWS, slope
from ema_tools.words.page.results import ShownComparison, ShownIdentification, parse_result
from report_results import ROWS, compared, identified

_VOID = {"meta", "link", "br", "col", "img", "input", "hr"}


def _made(data: dict[str, Any]) -> ShownIdentification:
    result = parse_result(data, "today.json", "today")
    assert isinstance(result, ShownIdentification)
    return result


def _page(folder: Path, *results: dict[str, Any]) -> str:
    files = []
    for place, result in enumerate(results):
        files.append(folder / f"result_{place}.json")
        files[-1].write_text(json.dumps(result), encoding="utf-8")
    output = folder / "page.html"
    write_report(files, output, "ema report result_0.json -o page.html", force=True)
    return output.read_text(encoding="utf-8")


def _without_scripts(page: str) -> str:
    return re.sub(r"<script>.*?</script>", "", page, flags=re.DOTALL)


class _Structure(HTMLParser):
    """Collects problems of nesting and identity, and every address that the page could load."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.identities: list[str] = []
        self.references: list[str] = []
        self.loads: list[str] = []
        self.problems: list[str] = []
        self.texts: list[str] = []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        if tag not in _VOID:
            self.open.append(tag)
        for name, value in attributes:
            if name == "id":
                self.identities.append(value or "")
            if name == "aria-labelledby" or (name == "href" and (value or "").startswith("#")):
                self.references.append((value or "").lstrip("#"))
            elif name in ("src", "href", "srcset", "data", "action"):
                self.loads.append(value or "")

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open.pop() != tag:
            self.problems.append(f"</{tag}> at {self.getpos()}")

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def _structure(page: str) -> _Structure:
    found = _Structure()
    found.feed(page)
    found.close()
    return found


def test_page_is_well_formed_and_loads_nothing(tmp_path: Path) -> None:
    page = _page(tmp_path, identified(case="A"), identified(case="B", noise="5 µm sensor noise"), identified(name="today"), compared())
    assert len(page.encode()) < 8_000_000
    found = _structure(_without_scripts(page))
    assert found.problems == [] and found.open == []
    assert len(found.identities) == len(set(found.identities))
    assert set(found.references) <= set(found.identities)
    assert found.loads == ["data:,"]
    assert "@import" not in page.split("</style>")[0] and "url(" not in page.split("</style>")[0]
    # Control characters make a document invalid; plotly.js has some in its strings.
    assert not re.search(r"[\x00-\x08\x0b\x0e-\x1f\x7f]", page)


def test_page_says_what_was_found(tmp_path: Path) -> None:
    texts = _structure(_without_scripts(_page(tmp_path, identified(case="A")))).texts
    text = " ".join("".join(texts).replace("\u00a0", " ").split())
    assert "The machine has a fault: friction (CSJ) +117.4 % and backlash (BLK) +25.0 %." in text
    assert "7 model runs in 0.070 s" in text
    assert "0.674 → 2.50×10⁻⁴ mm² s (−99.962 %)" in text
    assert "○ true +117.4 %; ◇ paper +115.2 %" in text and "2535" in text
    assert "ema report result_0.json -o page.html" in text
    assert "ema identify reference.toml today.csv" in text


def test_names_cannot_break_the_page(tmp_path: Path) -> None:
    hostile = "</script><script>alert(1)</script>\"'&"
    page = _page(
        tmp_path,
        identified(name=hostile, provenance={hostile: hostile}),
        compared(sentence=hostile, where=[{"name": hostile, "share_percent": 60.0, "time_share": 0.1}]),
    )
    assert "alert(1)</script>" not in page
    assert page.count("<script") == 3
    assert hostile in "".join(_structure(_without_scripts(page)).texts)


def test_undecided_verdict_gets_advice(tmp_path: Path) -> None:
    reason = "an estimate lies on a bound of its search"
    page = _page(tmp_path, identified(verdict="undecided", reasons=[reason]))
    assert f"<li>{reason[0].upper()}{reason[1:]}. Widen the bounds" in page
    assert f"<h1>No verdict: {reason}.</h1>" in page and "is what fits best, and does not stand" in page


def test_healthy_verdict_is_not_called_a_fault(tmp_path: Path) -> None:
    page = _page(tmp_path, identified(verdict="healthy"))
    assert "<h1>The machine is healthy: friction (CSJ) " in page and "has a fault" not in _without_scripts(page)
    both = _page(tmp_path, identified(verdict="healthy"), compared())
    assert "<h1>2 results: 1 healthy and 1 compared with the model.</h1>" in both and "has a fault" not in _without_scripts(both)


def test_result_without_curves_and_search_is_shown(tmp_path: Path) -> None:
    bare = {key: value for key, value in identified().items() if key not in ("curves", "search", "wall_s", "provenance")}
    page = _page(tmp_path, bare)
    assert "The result holds no curves" in page and 'class="gauge ' in page and "Run by run" not in page
    both = _page(tmp_path, bare, bare)
    assert "data-curves=" not in _without_scripts(both)
    assert both.count('class="gauge bad"') == 4 and "The search</h3>" not in both


def _broken(path: str, value: Any) -> dict[str, Any]:
    """The sound result with one entry replaced, or removed where `value` is Ellipsis."""
    result = identified()
    *outer, last = path.split(".")
    table = result
    for key in outer:
        table = table[key]
    if value is ...:
        del table[last]
    else:
        table[last] = value
    return result


@pytest.mark.parametrize(
    ("path", "value", "expected"),
    [
        ("csj_Nm.std", ..., "field csj_Nm.std is missing"),
        ("csj_Nm.estimate", "0.3", "field csj_Nm.estimate is not a number"),
        ("csj_Nm.shift_percent", -100.0, "field csj_Nm.shift_percent is not above -100"),
        ("evaluations", True, "field evaluations is not a number"),
        ("reasons", "none", "field reasons is not a list of texts"),
        ("case", "Z", "field case names no case"),
        ("search.cost_mm2s", [], "field search.cost_mm2s is not a list of numbers"),
        ("search.cost_mm2s", [1.0, None], "field search.cost_mm2s is not finite at row 2"),
        ("curves.period_s", 0.0, "field curves.period_s is not positive"),
        ("curves.after.position_mm", [0.0] * 5, f"field curves.after.position_mm has 5 rows where measured.position_mm has {ROWS}"),
        ("curves.before.position_mm", ..., "field curves.before.position_mm is missing"),
        ("provenance", [], "field provenance is not an object"),
    ],
)
def test_bad_field_is_named(path: str, value: Any, expected: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_result(_broken(path, value), "today.json", "today")
    message = str(caught.value)
    assert message.startswith("today.json: ") and expected in message and "\n" not in message and "--json" in message


def test_one_fault_alone_is_shown(tmp_path: Path) -> None:
    alone = {key: value for key, value in identified().items() if key != "blk_mm"}
    page = _page(tmp_path, alone)
    assert "has a fault: friction (CSJ) +117.4" in page and "BLK</th>" not in page and 'data-fault="blk_mm"' not in page
    with pytest.raises(InputError, match="field blk_mm is missing"):
        parse_result({**alone, "case": "A"}, "today.json", "today")


def test_comparison_names_the_worst_balance(tmp_path: Path) -> None:
    page = _page(tmp_path, compared(name="today.csv"))
    assert "<h1>The model leaves 4.08\u00a0% unexplained in the mechanics; the rod position is off by 5.00\u00a0%.</h1>" in page
    assert page.count("Most of the error is in the mechanical balance.") == 1
    page = _page(tmp_path, compared(name="today.csv", balances={}))
    assert "<h1>No equation can be weighed on this record; the rod position is off by 5.00\u00a0%.</h1>" in page


def test_rod_that_does_not_move_is_said(tmp_path: Path) -> None:
    still = compared(name="still", channels={"position_mm": {"rmse": 0.0, "relative_percent": None}})
    assert "the rod does not move" in _page(tmp_path, still, identified())


def test_other_json_and_missing_file_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="none of `csj_Nm`, `blk_mm` and `balances`"):
        parse_result({"rows": 5}, "x.json", "x")
    with pytest.raises(InputError, match=r"x\.json: the result of `ema effects` has no page"):
        parse_result({"command": "effects", "effects": []}, "x.json", "x")
    with pytest.raises(InputError, match=r"x\.json: format 2 is newer than this ema"):
        parse_result({**identified(), "format": 2}, "x.json", "x")
    with pytest.raises(InputError, match=r"x\.json: field csj_Nm\.colour is unknown to this ema"):
        parse_result({**identified(), "csj_Nm": {**identified()["csj_Nm"], "colour": "red"}}, "x.json", "x")
    with pytest.raises(InputError, match=r"absent\.json"):
        write_report([tmp_path / "absent.json"], tmp_path / "page.html", "ema report")
    with pytest.raises(InputError, match="no result"):
        write_report([], tmp_path / "page.html", "ema report")
    assert not (tmp_path / "page.html").exists()


def test_nothing_is_overwritten_unless_asked(tmp_path: Path) -> None:
    _page(tmp_path, identified())
    before = (tmp_path / "page.html").read_bytes()
    with pytest.raises(InputError, match="--force"):
        write_report([tmp_path / "result_0.json"], tmp_path / "page.html", "another")
    assert (tmp_path / "page.html").read_bytes() == before


def test_slope_is_exact_for_a_line_and_smooths_noise() -> None:
    time = np.arange(200) * 1e-3
    assert slope(3.0 - 40.0 * time, 1e-3) == pytest.approx(np.full(200, -40.0), abs=1e-9)
    noise = np.random.default_rng(1).normal(0.0, 1.0, 5000)
    inner = slope(noise, 1.0)[SLOPE_ROWS:-SLOPE_ROWS]
    # Standard error of a slope over 9 rows: 1 / sqrt(60).
    assert float(np.std(inner)) == pytest.approx(1.0 / np.sqrt(60.0), rel=0.05)


def _unpack(packed: dict[str, Any]) -> np.ndarray:
    return np.frombuffer(base64.b64decode(packed["int16"]), dtype="<i2") * packed["scale"]


def test_packed_curves_keep_their_values() -> None:
    curves = _made(identified()).curves
    assert curves is not None
    packed = pack(curves)
    assert [channel["title"] for channel in packed["channels"]] == ["Rod position", "Rod speed", "Motor current"]
    position = packed["channels"][0]
    assert np.max(np.abs(_unpack(position["measured"]) - curves.measured["position_mm"])) <= 2.0 / 65000.0
    residual_um = 1000.0 * (curves.measured["position_mm"] - curves.models["after"]["position_mm"])
    assert np.max(np.abs(_unpack(position["residual"]["after"]) - residual_um)) <= 1.0 / 65000.0
    assert position["rms"]["after"] == pytest.approx(1.0)
    assert "kept" not in packed["time"]


def test_long_record_keeps_its_extremes() -> None:
    data = identified()
    spike = 777
    data["curves"]["after"]["current_A"][spike] += 50.0
    curves = _made(data).curves
    assert curves is not None
    packed = pack(curves, thin=200)
    kept = np.frombuffer(base64.b64decode(packed["time"]["kept"]), dtype="<u4")
    assert kept.size <= 200 + 2 and kept[0] == 0 and kept[-1] == ROWS - 1 and np.all(np.diff(kept.astype(int)) > 0)
    assert spike in kept
    current = packed["channels"][2]
    assert _unpack(current["residual"]["after"])[list(kept).index(spike)] == pytest.approx(-50.01, abs=0.01)


def test_figures_are_drawn() -> None:
    result = _made(identified(case="A"))
    comparison = parse_result(compared(), "c.json", "c")
    assert isinstance(comparison, ShownComparison)
    for figure in (figures.search(result), figures.accuracy([result]), figures.shares(comparison.where)):
        drawn = ElementTree.fromstring(figure_svg(figure, "f"))
        assert drawn.attrib["aria-label"] == figure["label"]
        assert figure["label"] and all("role" in trace["meta"] for trace in figure["data"])


def test_sizes_stand_beside_truth_and_paper() -> None:
    shown = gauges(_made(identified(case="A")))
    assert (
        "○ true +117.4\u00a0%; ◇ paper +115.2\u00a0%" in shown
        and shown.count('class="mark ring"') == shown.count('class="mark diamond"') == 2
    )
    noisy = gauges(_made(identified(case="A", noise="5 µm")))
    assert "paper" not in noisy and noisy.count('class="mark ring"') == 2


def test_search_shows_every_candidate_and_the_best() -> None:
    candidates, best = figures.search(_made(identified()))["data"]
    assert candidates["y"] == [0.674, 1.2, 0.1, 0.3, 0.01, 2.5e-4, 2.6e-4]
    assert best["y"] == [0.674, 0.674, 0.1, 0.1, 0.01, 2.5e-4, 2.5e-4]
    exact = figures.search(_made(identified(search={"cost_mm2s": [0.5, 0.0]})))["data"]
    assert min(exact[0]["y"]) > 0.0


def test_places_without_surprise_are_left_out() -> None:
    result = parse_result(compared(), "c.json", "c")
    assert isinstance(result, ShownComparison)
    assert [place.name for place in result.where] == ["rod position: speed 0 to 5 mm/s"]


def test_the_page_is_small_enough_to_send(tmp_path: Path) -> None:
    page = _page(tmp_path, identified(case="A"))
    assert len(page.encode()) < 250_000
    assert _page(tmp_path, identified(case="A")) == page


def test_what_was_not_identified_is_shown_with_its_reason(tmp_path: Path) -> None:
    """An axis without backlash, as EMPS: BLK has no estimate, and the page says why."""
    why = "the healthy value is zero, and a shift is counted in % of it"
    data = identified(blk_mm={"estimate": None, "std": None, "shift_percent": None, "healthy": 0.0, "reason": why})
    result = _made(data)
    assert set(result.faults) == {"csj_Nm"} and result.left_out == {"blk_mm": why}
    page = _page(tmp_path, data)
    assert f"not identified: {why}</td>" in page and 'data-fault="blk_mm"' not in page
    assert "<h1>The machine has a fault: friction (CSJ) +117.4\u00a0%.</h1>" in page
    both = _page(tmp_path, data, compared())
    assert f"BLK, backlash at the rod: not identified: {why}.</p>" in both and "has a fault: friction (CSJ) +117.4\u00a0%." in both
    assert gauges(result).count("data-fault=") == 1
    with pytest.raises(InputError, match=r"today.json: field blk_mm.estimate is missing"):
        parse_result(identified(blk_mm={"estimate": None, "std": None}), "today.json", "today")
    with pytest.raises(InputError, match=r"today.json: field csj_Nm.estimate is null for every parameter"):
        parse_result(identified(csj_Nm=data["blk_mm"], blk_mm=data["blk_mm"]), "today.json", "today")


def test_value_without_a_standard_error_is_shown_without_an_interval(tmp_path: Path) -> None:
    data = identified(csj_Nm={"estimate": 0.3, "std": None, "shift_percent": 117.3913, "healthy": 0.138}, verdict="undecided")
    assert (
        'class="interval"' in gauges(_made(data)).split('data-fault="blk_mm"')[1]
        and 'class="interval"' not in gauges(_made(data)).split('data-fault="blk_mm"')[0]
    )
    assert "<span>not determined by this record</span>" in _page(tmp_path, data, data)
    assert "not determined by this record" in _page(tmp_path, data)
