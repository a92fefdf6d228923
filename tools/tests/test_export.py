"""The header for firmware compiles in both precisions and holds the actuator's values; the flat text is read by the host program."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ema_tools.data.actuator import read_actuator, reference_actuator
from ema_tools.library.definitions import library_folder, load_definitions
from ema_tools.tasks.export import flat_text, header_text, literal
from support import RECORDINGS, REFERENCE, ROOT, complaint, run_ema

PROGRAM = """
#include <stdio.h>
#include <string.h>
#include "actuator.h"
int main(void)
{
    ema_real values[EMA_VALUE_COUNT];
    int32_t options[EMA_OPTION_COUNT];
    memcpy(values, &EMA_ACTUATOR.params, sizeof EMA_ACTUATOR.params);
    memcpy(values + EMA_PARAM_COUNT, &EMA_ACTUATOR.effects, sizeof EMA_ACTUATOR.effects);
    memcpy(options, &EMA_ACTUATOR.options, sizeof options);
    for (size_t k = 0; k < EMA_VALUE_COUNT; ++k) {
        printf("%a\\n", (double)values[k]);
    }
    for (size_t k = 0; k < EMA_OPTION_COUNT; ++k) {
        printf("%d\\n", (int)options[k]);
    }
    return 0;
}
"""
FLAGS = ["-std=c11", "-pedantic-errors", "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Werror"]


@given(st.floats(-1e30, 1e30, allow_nan=False))
def test_literal_is_exact(value: float) -> None:
    match = re.fullmatch(r"EMA_R\((.*)\)", literal(value))
    assert match is not None
    text = match.group(1)
    assert (float.fromhex(text) if "x" in text else float(text)) == value


@pytest.mark.parametrize("bits", [32, 64])
def test_header_compiles_and_holds_the_values(tmp_path: Path, bits: int) -> None:
    compiler = os.environ.get("CC") or shutil.which("cc") or shutil.which("gcc")
    if not compiler:
        pytest.skip("no C compiler: install one or name it in CC")
    changes = {"screw.csj_Nm": 0.1 + 0.2, "stribeck_friction.rise": 1.0 / 3.0, "screw.load_torque_Nm": -1.0 / 7.0, "control.structure": 1}
    actuator = reference_actuator().changed(changes)
    (tmp_path / "actuator.h").write_text(header_text(actuator), encoding="utf-8")
    (tmp_path / "main.c").write_text(PROGRAM, encoding="utf-8")
    command = [compiler, *FLAGS, f"-DEMA_REAL64={int(bits == 64)}", f"-I{ROOT / 'include'}", "main.c", "-o", "main"]
    subprocess.run(command, cwd=tmp_path, check=True)
    lines = subprocess.run([tmp_path / "main"], check=True, capture_output=True, text=True).stdout.split()
    values, options = actuator.arrays()
    expected = values.astype(np.float32).astype(float) if bits == 32 else values
    assert [float.fromhex(line) for line in lines[: values.size]] == expected.tolist()
    assert [int(line) for line in lines[values.size :]] == options.tolist()


def test_flat_text_is_read_by_the_host_program(tmp_path: Path) -> None:
    program = library_folder().parent / "bin" / "ema_identify"
    if not program.is_file():
        pytest.skip(f"{program.name} is not built: build the project")
    ran = run_ema("export", REFERENCE, "-o", tmp_path / "a.h", "--flat", tmp_path / "a.txt")
    assert ran.code == 0, ran.err
    answers = [
        subprocess.run([program, *how, RECORDINGS / "case_a.csv"], capture_output=True, text=True, check=True).stdout.splitlines()[0]
        for how in (["--config", tmp_path / "a.txt"], ["--reference"])
    ]
    assert answers[0].split(":")[0] == answers[1].split(":")[0]


NAMES = ("line\nscrew.csj_Nm = 9", "a\r\nb\x00\tc\x1bd\u2028e", "*/ int x; /*", "long " * 400, "\\\n")


@pytest.mark.parametrize("name", NAMES)
def test_no_name_breaks_what_is_exported(tmp_path: Path, name: str) -> None:
    actuator = reference_actuator().changed({}, {"name": name})
    head, *values = flat_text(actuator).splitlines()
    assert values == flat_text(reference_actuator()).splitlines()[1:]
    assert head.startswith("# ") and head.isprintable() and len(head.encode()) < 1024
    assert header_text(actuator).splitlines()[1:] == header_text(reference_actuator()).splitlines()[1:]
    comment = header_text(actuator).splitlines()[0]
    assert comment.count("*/") == comment.count("/*") == 1 and comment.endswith("*/")
    actuator.write(tmp_path / "a.toml")
    assert read_actuator(tmp_path / "a.toml").about["name"] == name


def test_flat_text_names_everything() -> None:
    lines = dict(line.split(" = ") for line in flat_text(reference_actuator()).splitlines()[1:])
    known = load_definitions()
    assert len(lines) == len(known.parameters) + len(known.effect_values)
    assert lines["control.structure"] == "pid"
    assert lines["control.average_speed"] == "no"
    assert lines["control.every_steps"] == "1"
    assert lines["screw.csj_Nm"] == "0.138"
    assert lines["effects.stribeck_friction.rise"] == "0.0"


def test_actuator_that_the_onboard_module_refuses_is_not_exported(tmp_path: Path) -> None:
    actuator = read_actuator(REFERENCE).changed({"search.csj_upper_Nm": 100.0})
    actuator.write(tmp_path / "a.toml")
    assert run_ema("export", tmp_path / "a.toml", "-o", tmp_path / "a.h").code == 0
    message = complaint(run_ema("export", tmp_path / "a.toml", "-o", tmp_path / "a.h"))
    assert message.endswith("a.h: exists already: choose another name or give --force")
    assert run_ema("export", tmp_path / "a.toml", "-o", tmp_path / "a.h", "--force").code == 0


def test_a_healthy_value_outside_its_search_is_not_exported(tmp_path: Path) -> None:
    read_actuator(REFERENCE).changed({"search.csj_lower_Nm": 0.2}).write(tmp_path / "narrow.toml")
    message = complaint(run_ema("export", tmp_path / "narrow.toml", "-o", tmp_path / "out.h"))
    assert "screw.csj_Nm = 0.138: outside the search's bounds 0.2 .. " in message
    assert not (tmp_path / "out.h").exists()


def test_header_names_no_path() -> None:
    assert str(ROOT) not in header_text(read_actuator(REFERENCE))
