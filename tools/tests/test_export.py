"""The files for firmware compile as C11 and C++11 and hold the actuator's values as float32; the flat text is read by the host program."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ema_tools.data.actuator import Actuator, read_actuator, reference_actuator
from ema_tools.library.definitions import library_folder, load_definitions
from ema_tools.tasks.export import declaration_text, flat_text, header_text, literal, source_text
from support import EXPORTED, RECORDINGS, REFERENCE, ROOT, complaint, run_ema

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
FLAGS = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Werror"]
CHANGES = {"screw.csj_Nm": 0.1 + 0.2, "stribeck_friction.rise": 1.0 / 3.0, "screw.load_torque_Nm": -1.0 / 7.0, "control.structure": 1}
# Parts of one program: each gives the address of the constant that it sees.
PART = """
#include "actuator.h"
const ema_actuator_t* PART(void);
const ema_actuator_t* PART(void) { return &EMA_ACTUATOR; }
"""
PARTS = """
#include "actuator.h"
const ema_actuator_t* first(void);
const ema_actuator_t* second(void);
int main(void) { return (first() == &EMA_ACTUATOR) && (second() == &EMA_ACTUATOR) ? 0 : 1; }
"""


def compiler_of(language: str) -> list[str]:
    """The command of a compiler, with its standard; the test is skipped without one."""
    names, standard = {"c": (("CC", "cc", "gcc"), "-std=c11"), "c++": (("CXX", "c++", "g++"), "-std=c++11")}[language]
    path = os.environ.get(names[0]) or shutil.which(names[1]) or shutil.which(names[2])
    if not path:
        pytest.skip(f"no compiler of {language}: install one or name it in {names[0]}")
    return [path, "-x", language, standard, *FLAGS, f"-I{ROOT / 'include'}"]


def printed_values(folder: Path, command: list[str], *sources: str) -> tuple[list[float], list[int]]:
    """Values and options that a program prints, compiled with the exported files in `folder`."""
    (folder / "main.c").write_text(PROGRAM, encoding="utf-8")
    subprocess.run([*command, "main.c", *sources, "-o", "main"], cwd=folder, check=True)
    lines = subprocess.run([folder / "main"], check=True, capture_output=True, text=True).stdout.split()
    count = len(load_definitions().value_names)
    return [float.fromhex(line) for line in lines[:count]], [int(line) for line in lines[count:]]


def float32_values(actuator: Actuator) -> tuple[list[float], list[int]]:
    """Values as float32 and options."""
    values, options = actuator.arrays()
    return values.astype(np.float32).astype(float).tolist(), options.tolist()


@given(st.floats(-1e30, 1e30, allow_nan=False))
def test_literal_is_decimal_and_has_the_float32_value(value: float) -> None:
    text = literal(value)
    assert re.fullmatch(r"-?\d+(\.\d+)?(e[-+]\d+)?f", text) and ("." in text or "e" in text)
    assert np.float32(text[:-1]) == np.float32(value)
    assert len(Decimal(text[:-1]).normalize().as_tuple().digits) <= 9


@pytest.mark.parametrize("language", ["c", "c++"])
@pytest.mark.parametrize("bits", [32, 64])
def test_header_compiles_and_holds_the_values(tmp_path: Path, bits: int, language: str) -> None:
    actuator = reference_actuator().changed(CHANGES)
    (tmp_path / "actuator.h").write_text(header_text(actuator), encoding="utf-8")
    assert printed_values(tmp_path, [*compiler_of(language), f"-DEMA_REAL64={int(bits == 64)}"]) == float32_values(actuator)


@pytest.mark.parametrize("language", ["c", "c++"])
def test_source_and_its_header_hold_the_values_once(tmp_path: Path, language: str) -> None:
    command = compiler_of(language)
    actuator = reference_actuator().changed(CHANGES)
    actuator.write(tmp_path / "a.toml")
    ran = run_ema("export", tmp_path / "a.toml", "-o", tmp_path / "actuator.c", "--json", tmp_path / "e.json")
    assert ran.code == 0, ran.err
    assert ran.out.split() == f"{tmp_path / 'actuator.c'} written, {tmp_path / 'actuator.h'} written".split()
    result = json.loads((tmp_path / "e.json").read_text(encoding="utf-8"))
    assert [Path(result[name]).name for name in ("source", "header")] == ["actuator.c", "actuator.h"]
    assert printed_values(tmp_path, command, "actuator.c") == float32_values(actuator)
    (tmp_path / "part.c").write_text(PART, encoding="utf-8")
    (tmp_path / "parts.c").write_text(PARTS, encoding="utf-8")
    for part in ("first", "second"):
        subprocess.run([*command, f"-DPART={part}", "-c", "part.c", "-o", f"{part}.o"], cwd=tmp_path, check=True)
    subprocess.run([*command, "parts.c", "actuator.c", "-x", "none", "first.o", "second.o", "-o", "parts"], cwd=tmp_path, check=True)
    assert subprocess.run([tmp_path / "parts"], check=False).returncode == 0


def test_cpp_program_links_the_source_compiled_as_c(tmp_path: Path) -> None:
    c, cpp = compiler_of("c"), compiler_of("c++")
    (tmp_path / "actuator.h").write_text(declaration_text(reference_actuator()), encoding="utf-8")
    (tmp_path / "actuator.c").write_text(source_text(reference_actuator(), "actuator.h"), encoding="utf-8")
    subprocess.run([*c, "-c", "actuator.c", "-o", "actuator.o"], cwd=tmp_path, check=True)
    assert printed_values(tmp_path, cpp, "-x", "none", "actuator.o") == float32_values(reference_actuator())


@pytest.mark.parametrize("language", ["c", "c++"])
def test_header_of_signatures_compiles(tmp_path: Path, language: str) -> None:
    (tmp_path / "main.c").write_text(
        f'#include "{EXPORTED / "ace_signatures.h"}"\nint main(void) {{ return EMA_SIGNATURES.faults == 2U ? 0 : 1; }}\n'
    )
    subprocess.run([*compiler_of(language), "main.c", "-o", "main"], cwd=tmp_path, check=True)
    subprocess.run([tmp_path / "main"], check=True)


def test_no_header_beside_a_source_is_overwritten(tmp_path: Path) -> None:
    (tmp_path / "a.h").write_text("mine", encoding="utf-8")
    assert complaint(run_ema("export", REFERENCE, "-o", tmp_path / "a.c")).endswith(
        "a.h: exists already: choose another name or give --force"
    )
    assert [path.name for path in tmp_path.iterdir()] == ["a.h"]


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
