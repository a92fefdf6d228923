"""`ema watch`: curves and verdict follow a recording that grows, on a page that this machine alone can ask for."""

from __future__ import annotations

import json
import threading
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from ema_tools.cli import watching
from ema_tools.data.actuator import read_actuator
from ema_tools.data.growing import Growing
from ema_tools.tasks.watch import Watch
from ema_tools.words.live.page import page
from ema_tools.words.live.server import LiveServer
from ema_tools.words.live.state import state
from in_browser import PHONE, launched
from support import RECORDINGS, REFERENCE, Ran, complaint, run_ema

UNIT = RECORDINGS / "unit"
LINES = (RECORDINGS / "case_a.csv").read_bytes().splitlines(keepends=True)


class Clock:
    """Seconds that pass when the test says so."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def append(path: Path, lines: list[bytes]) -> None:
    with path.open("ab") as stream:
        stream.write(b"".join(lines))


@pytest.mark.slow
def test_it_follows_searches_and_judges(tmp_path: Path) -> None:
    path, clock = tmp_path / "r.csv", Clock()
    actuator = read_actuator(REFERENCE)
    watch = Watch(actuator, Growing(path), clock=clock)
    assert not watch.step()
    assert state(watch.seen, actuator, "r.csv")["headline"] == "Waiting for the first rows of r.csv."
    append(path, LINES[:600])
    assert watch.step()
    assert watch.seen.phase == "recording"
    assert watch.seen.so_far is None
    clock.now = 2.0
    append(path, LINES[600:6000])
    assert watch.step()
    so_far = state(watch.seen, actuator, "r.csv")
    assert so_far["headline"].startswith("Recording: ")
    assert {one["title"] for one in so_far["values"]} == {"CSJ", "BLK"}
    assert all(one["so_far"] for one in so_far["values"])
    before = watch.seen.version
    clock.now = 4.0
    assert not watch.step()
    assert watch.seen.version == before
    append(path, LINES[6000:])
    assert watch.step()
    clock.now = 6.9
    assert not watch.step()
    clock.now = 7.1
    assert watch.step()
    assert watch.seen.phase == "judged"
    assert watch.seen.found is not None
    told = state(watch.seen, actuator, "r.csv")
    alone = tmp_path / "alone.json"
    assert run_ema("identify", REFERENCE, RECORDINGS / "case_a.csv", "--json", alone).code == 0
    wanted = json.loads(alone.read_text(encoding="utf-8"))
    assert told["headline"] == wanted["sentence"]
    assert [one["shift_percent"] for one in told["values"]] == [wanted["csj_Nm"]["shift_percent"], wanted["blk_mm"]["shift_percent"]]
    assert {one["name"] for one in told["channels"]} == {"position_mm", "motor_position_mm", "current_A", "voltage_V"}
    assert max(len(one["time"]) for one in told["channels"]) <= 2001
    json.dumps(told, allow_nan=False)


def test_what_happens_to_the_file_is_said_and_nothing_that_was_read_is_lost(tmp_path: Path) -> None:
    path, clock = tmp_path / "r.csv", Clock()
    watch = Watch(read_actuator(REFERENCE), Growing(path), clock=clock)
    append(path, [*LINES[:400], b"0.4,1,nan,0,0,0\n"])
    assert watch.step()
    assert "r.csv: row 401" in watch.seen.trouble
    path.write_bytes(b"".join(LINES[:400]))
    assert watch.step()
    assert watch.seen.record is not None
    rows = watch.seen.record.rows
    append(path, [b"0.4,1,nan,0,0,0\n"])
    assert watch.step()
    assert watch.seen.record.rows == rows
    assert "row 401" in watch.seen.trouble
    path.write_bytes(b"".join(LINES[:200]))
    assert watch.step()
    assert watch.seen.notes[-1] == f"r.csv was begun anew after {rows} rows"
    assert watch.seen.trouble == ""
    clock.now = 5.0
    assert watch.step()
    assert watch.seen.phase == "judged"
    assert watch.seen.found is not None
    assert watch.seen.found.verdict == "undecided"
    append(path, LINES[200:300])
    assert watch.step()
    assert watch.seen.phase == "recording"
    assert "grew again" in watch.seen.notes[-1]


@pytest.fixture
def served() -> Iterator[LiveServer]:
    server = LiveServer(page("unit", "<r>.csv"), lambda seen: None if seen == "3" else {"version": 3})
    yield server
    server.close()


def ask(url: str, host: str | None = None) -> tuple[int, str, Any]:
    request = urllib.request.Request(url, headers={"Host": host} if host else {})
    try:
        with urllib.request.urlopen(request, timeout=10) as answer:
            return answer.status, answer.read().decode(), answer.headers
    except urllib.error.HTTPError as refused:
        return refused.code, refused.read().decode(), refused.headers


def test_the_server_answers_this_machine_alone(served: LiveServer) -> None:
    assert served.url.startswith("http://127.0.0.1:")
    status, text, headers = ask(served.url)
    assert (status, headers["Cache-Control"]) == (200, "no-store")
    assert "connect-src 'self'" in headers["Content-Security-Policy"]
    assert "&lt;r&gt;.csv" in text
    assert "<r>" not in text
    assert ask(served.url + "state")[:2] == (200, '{"version": 3}')
    assert ask(served.url + "state?seen=3")[0] == 204
    assert ask(served.url + "../etc")[0] == 404
    assert ask(served.url, "elsewhere.example:80")[0] == 403
    port = int(served.url.rsplit(":", 1)[1].strip("/"))
    with pytest.raises(Exception, match=rf"--port {port}: address already in use"):
        LiveServer("", lambda _: None, port)


def complaint_after(ran: Ran) -> str:
    """The complaint of a command that has said where its page is."""
    assert ran.code == 1
    return complaint(Ran(ran.code, "", ran.err))


def test_once_it_ends_with_the_verdict(tmp_path: Path) -> None:
    asked = ("watch", REFERENCE, RECORDINGS / "healthy.csv", "--once", "--quiet", "0.2", "--exit-code", "--json", tmp_path / "w.json")
    ran = run_ema(*asked)
    assert ran.code == 0, ran
    assert "http://127.0.0.1:" in ran.out
    assert "Healthy: " in ran.out
    assert json.loads((tmp_path / "w.json").read_text(encoding="utf-8"))["verdict"] == "healthy"
    short = tmp_path / "short.csv"
    append(short, LINES[:50])
    ran = run_ema("watch", REFERENCE, short, "--once", "--quiet", "0.2")
    assert ran.code == 1
    assert "ended without a verdict" in ran.out
    assert ran.err.startswith("ema: short.csv")
    assert "a folder" in complaint_after(run_ema("watch", REFERENCE, tmp_path, "--once"))
    assert "healthy.csv" in complaint(run_ema(*asked[:3], "--once", "--json", RECORDINGS / "healthy.csv", "--force"))


def test_an_interrupt_ends_it_with_what_was_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    slept = 0

    def sleep(_: float) -> None:
        nonlocal slept
        slept += 1
        if slept > 2:
            raise KeyboardInterrupt

    monkeypatch.setattr(watching.time, "sleep", sleep)
    ran = run_ema("watch", REFERENCE, RECORDINGS / "healthy.csv")
    assert ran.code == 0
    assert "ended without a verdict" in ran.out
    assert threading.active_count() < 20


@pytest.mark.slow
def test_an_undecided_recording_is_told_in_a_short_sentence_with_its_reasons_below(tmp_path: Path) -> None:
    path, clock, actuator = tmp_path / "r.csv", Clock(), read_actuator(REFERENCE)
    watch = Watch(actuator, Growing(path), clock=clock)
    append(path, (RECORDINGS / "story" / "today.csv").read_bytes().splitlines(keepends=True))
    watch.step()
    clock.now = 9.0
    watch.step()
    told = state(watch.seen, actuator, "r.csv")
    assert told["headline"].startswith("Undecided: the search reads CSJ +") and told["headline"].endswith("%, which does not stand.")
    assert len(told["headline"]) < 90
    named = next(one for one in told["details"] if "stribeck_friction" in one)
    # what is to be typed has its files, as everywhere
    assert named.startswith("Stribeck friction (stribeck_friction; rise ") and "--fit r.csv" in named and "ACTUATOR" not in named
    # no finer than its interval, which is wide here
    assert all(one["told"].endswith("; does not stand") and "." not in one["shown"] for one in told["values"])


@pytest.mark.slow
def test_the_page_follows_in_a_browser(tmp_path: Path) -> None:
    with launched() as opened:
        path, clock = tmp_path / "r.csv", Clock()
        actuator = read_actuator(REFERENCE)
        watch = Watch(actuator, Growing(path), clock=clock)
        server = LiveServer(
            page(actuator.name, "r.csv"), lambda seen: None if seen == str(watch.seen.version) else state(watch.seen, actuator, "r.csv")
        )
        complaints: list[str] = []
        shown = opened.new_page(viewport=PHONE)
        shown.on("console", lambda one: complaints.append(one.text))
        shown.on("pageerror", lambda one: complaints.append(str(one)))
        shown.goto(server.url)
        shown.wait_for_selector("body[data-phase=waiting]")
        clock.now = 2.0
        append(path, LINES[:6000])
        watch.step()
        shown.wait_for_selector("body[data-phase=recording]")
        # The rows are shown before they are searched: a page may ask between the two.
        shown.wait_for_function("() => document.getElementById('values').textContent.includes('by the rows so far')")
        assert shown.locator(".channel canvas").count() == 8
        append(path, LINES[6000:])
        watch.step()
        clock.now = 9.0
        watch.step()
        shown.wait_for_selector("body[data-phase=judged]")
        shown.wait_for_function("seen => document.body.dataset.version === String(seen)", arg=watch.seen.version)
        assert shown.inner_text("#headline").replace("\u00a0", " ") == state(watch.seen, actuator, "r.csv")["headline"]
        assert shown.evaluate("() => document.documentElement.scrollWidth") <= 390
        # a key switches its series in every plot
        shown.locator('input[data-show="measured"]').focus()
        shown.keyboard.press("Space")
        assert not shown.locator('input[data-show="measured"]').is_checked() and shown.locator('input[data-show="after"]').is_checked()
        assert not complaints
        server.close()
        shown.wait_for_function("() => document.getElementById('state').textContent.includes('has ended')")
