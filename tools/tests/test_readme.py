"""The README tells the truth: its output, its commands, its folders, its links, and its firmware example."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from ema_tools.cli import cli
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import read_record
from ema_tools.library.definitions import library_folder
from ema_tools.tasks.export import header_text
from shown_output import missing_from, shown_by_demo

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")

_MAIN = """
#include <stdio.h>
#include "example.c"

int main(void)
{
    double command_mm = 0.0;
    double position_mm = 0.0;
    ema_result_t result;
    if (!health_begin()) {
        return 1;
    }
    while (scanf("%lf %lf", &command_mm, &position_mm) == 2) {
        if (!health_sample((ema_real)command_mm, (ema_real)position_mm)) {
            return 2;
        }
    }
    bool done = false;
    while (!done) {
        const ema_status_t status = health_work(&result, &done);
        if (status != EMA_OK) {
            printf("%s\\n", ema_status_text(status));
            return 3;
        }
    }
    printf("%.9g %.9g %d\\n", (double)result.identified[0].shift_percent, (double)result.identified[1].shift_percent, (int)result.verdict);
    return 0;
}
"""


def _blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", README, flags=re.MULTILINE | re.DOTALL)


@pytest.mark.slow
def test_output_is_what_the_demo_prints() -> None:
    assert [missing_from(block, real) for block, real in shown_by_demo()] == ["", ""]


def test_firmware_example_finds_the_fault(tmp_path: Path) -> None:
    compiler = next((path for name in ("cc", "gcc", "clang") if (path := shutil.which(name))), None)
    archive = library_folder() / "libema.a"
    if compiler is None or not archive.is_file():
        pytest.skip("the example is compiled with the module's static library: install a C compiler and build the project")
    example = next(block for block in _blocks("c") if "health_begin" in block)
    assert len(example.splitlines()) <= 30
    (tmp_path / "example.c").write_text(example, encoding="utf-8")
    (tmp_path / "main.c").write_text(_MAIN, encoding="utf-8")
    (tmp_path / "ema_actuator_data.h").write_text(header_text(reference_actuator()), encoding="utf-8")
    program = tmp_path / "program"
    subprocess.run(
        [
            compiler,
            "-std=c11",
            "-O2",
            "-Wall",
            "-Wextra",
            "-Werror",
            f"-I{ROOT / 'include'}",
            f"-I{tmp_path}",
            str(tmp_path / "main.c"),
            str(archive),
            "-o",
            str(program),
        ],
        check=True,
    )
    record = read_record(ROOT / "recordings" / "case_a.csv")
    rows = "".join(f"{command} {position}\n" for command, position in zip(record.command_mm, record.position_mm, strict=True))
    short = subprocess.run([str(program)], input="0 0\n" * 99, capture_output=True, text=True, timeout=120, check=False)
    assert (short.returncode, short.stdout) == (3, "the record is too short to identify from\n")
    done = subprocess.run([str(program)], input=rows, capture_output=True, text=True, check=True, timeout=120)
    csj, blk, verdict = (float(text) for text in done.stdout.split())
    # The record is kept in steps of 0.12 um here.
    assert csj == pytest.approx(117.391, abs=0.02) and blk == pytest.approx(25.0, abs=0.2) and verdict == 1.0


def test_commands_exist() -> None:
    named = set(re.findall(r"(?:build/)?ema ([a-z]+)", "\n".join([*_blocks(""), *_blocks("c"), *re.findall(r"`([^`\n]+)`", README)])))
    assert named >= {"calibrate", "identify", "report", "export", "compare"}
    assert named <= set(cli.commands)


def test_presets_exist() -> None:
    presets = json.loads((ROOT / "CMakePresets.json").read_text(encoding="utf-8"))
    for program, kind in (("cmake --workflow", "workflowPresets"), ("ctest", "testPresets")):
        named = set(re.findall(rf"{program} --preset ([\w-]+)", README))
        assert named and named <= {preset["name"] for preset in presets[kind]}, kind


def test_folders_and_links_exist() -> None:
    table = README.split("## Where things are")[1]
    for row in re.findall(r"^\| (`.*?) \|", table, flags=re.MULTILINE):
        for folder in re.findall(r"`([^`]+)`", row):
            assert (ROOT / folder).is_dir(), folder
    layers = re.search(r"the module: (.*?), each", table)
    assert layers is not None
    assert set(re.findall(r"`(\w+)`", layers.group(1))) == {path.name for path in (ROOT / "src").iterdir() if path.is_dir()}
    for link in re.findall(r"\]\(([^)#]+)[^)]*\)", README):
        assert (ROOT / link).is_file(), link


def _errors_stated(question: str) -> tuple[float, float]:
    """The errors of CSJ and BLK, in %, in the README's row of this question."""
    found = re.search(rf"^\| {question}.*?\| (\S+) % CSJ, (\S+) % BLK\b", README, flags=re.MULTILINE)
    assert found is not None, question
    return float(found.group(1)), float(found.group(2))


def test_accuracy_is_that_of_the_results() -> None:
    """The table's figures are those of docs/RESULTS.md, rounded up (to one digit, so by less than a factor of two)."""
    results = (ROOT / "docs" / "RESULTS.md").read_text(encoding="utf-8")
    own, rest = results.split("## Records of the truth plant")
    plant, noise = rest.split("## The same with sensor noise")
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in own.splitlines() if re.match(r"\| [ABC] \|", line)]
    worst = {fault: max(float(row[4]) for row in rows if row[1] == fault) for fault in ("CSJ", "BLK")}
    stated = dict(zip(("CSJ", "BLK"), _errors_stated("largest error in 1500 searches"), strict=True))
    assert all(worst[fault] <= stated[fault] <= 2.0 * worst[fault] for fault in worst), (worst, stated)
    assert f"at most {max(int(row[7]) for row in rows)} |" in README
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in plant.splitlines() if re.match(r"\| [ABC] \|", line)]
    for column, said in zip((1, 2), _errors_stated("the same on an independent model"), strict=True):
        highest = max(float(row[column]) for row in rows)
        assert highest <= said <= 2.0 * highest, (column, highest, said)
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in noise.splitlines() if re.match(r"\| [ABC] \|", line)]
    for fault, said in zip(("CSJ", "BLK"), _errors_stated("rms error with 5 µm sensor noise"), strict=True):
        highest = max(float(row[2]) for row in rows if row[1] == fault)
        assert highest <= said <= 2.0 * highest, (fault, highest, said)
    assert max(float(row[4]) for row in rows) <= 1.1
