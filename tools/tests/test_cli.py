"""The command line: help, exit codes, one line per complaint, nothing overwritten."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import click
import pytest

import ema_tools
from ema_tools.cli import cli
from ema_tools.cli.exit_codes import of_diagnosis, of_identification
from ema_tools.cli.sections import SECTIONS
from ema_tools.library.definitions import load_definitions
from support import RECORDINGS, REFERENCE, ROOT, complaint, run_ema

COMMANDS = ("simulate", "compare", "calibrate", "identify", "export", "report", "watch", "demo", "import", "effects")


def test_help_names_every_command() -> None:
    ran = run_ema("--help")
    assert ran.code == 0
    for command in COMMANDS:
        assert f"  {command}" in ran.out
        assert run_ema(command, "--help").code == 0


def test_help_follows_the_loop_and_leaves_no_command_out() -> None:
    shown = re.findall(r"^  (\w+)  +\S", run_ema("--help").out, re.MULTILINE)
    assert shown == [name for names in SECTIONS.values() for name in names]
    assert set(shown) == set(cli.commands)
    assert shown.index("compare") < shown.index("diagnose") < shown.index("add")
    assert not [line for line in run_ema("--help").out.splitlines() if line.startswith("  ") and line.endswith("...")]


@pytest.mark.parametrize(
    ("verdict", "guard", "code"),
    [("healthy", None, 0), ("fault", None, 4), ("undecided", None, 5), ("undecided", "unknown", 5), ("undecided", "missing", 3)],
)
def test_the_code_of_identify_is_its_verdict(verdict: str, guard: str | None, code: int) -> None:
    found = SimpleNamespace(
        verdict=verdict,
        missing_effect=object() if guard == "missing" else None,
        guard=SimpleNamespace(verdict=guard) if guard else None,
    )
    assert of_identification(cast(Any, found)) == code


@pytest.mark.parametrize(
    ("verdict", "faulty", "code"), [("adequate", False, 0), ("adequate", True, 4), ("missing", True, 3), ("unknown", True, 5)]
)
def test_the_code_of_diagnose_is_its_verdict(verdict: str, faulty: bool, code: int) -> None:
    found = SimpleNamespace(verdict=verdict, faults={"csj": SimpleNamespace(accepted=faulty)})
    assert of_diagnosis(cast(Any, found)) == code


def test_a_verdict_is_the_exit_code_where_it_is_asked_for() -> None:
    record = RECORDINGS / "case_a.csv"
    assert run_ema("identify", REFERENCE, record, "--no-guard").code == 0
    ran = run_ema("identify", REFERENCE, record, "--no-guard", "--exit-code")
    assert ran.code == 4 and "Fault" in ran.out


def test_version_is_the_projects() -> None:
    ran = run_ema("--version")
    assert ran.out.strip() == f"ema, version {ema_tools.__version__}"
    assert f'version = "{ema_tools.__version__}"' in (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert f"project(EMA VERSION {ema_tools.__version__} " in (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "arguments",
    [
        ("nothing",),
        ("simulate",),
        ("simulate", REFERENCE, "--command", "chirp"),
        ("simulate", REFERENCE, "--command", "chirp", "-o", "r.csv", "--seed", "one"),
        ("simulate", REFERENCE, "--command", "chirp", "-o", "r.csv", "--seed", "-1"),
        ("simulate", REFERENCE, "--command", "chirp", "-o", "r.csv", "--seed", 2**53),
        ("identify", REFERENCE, "a.csv", "--seed", 2**53),
        ("identify", REFERENCE),
        ("identify", REFERENCE, "a.csv", "b.csv"),
        ("identify", REFERENCE, "a.csv", "--precision", "16"),
        ("identify", REFERENCE, "a.csv", "--seeds", "0"),
        ("calibrate", REFERENCE, "-o", "n.toml"),
        ("export", REFERENCE),
        ("import", "other", "x.mat"),
        ("compare", "--wrong", REFERENCE, "a.csv"),
    ],
)
def test_wrong_usage_ends_with_two(arguments: tuple[object, ...]) -> None:
    ran = run_ema(*arguments)
    assert ran.code == 2
    assert "Usage: ema" in ran.err
    assert ran.out == ""


BAD = [
    (("simulate", "none.toml", "--command", "chirp", "-o", "r.csv"), "none.toml: no such file or directory: check the path"),
    (("simulate", REFERENCE, "--command", "none.csv", "-o", "r.csv"), "command none.csv: neither a file nor a command"),
    (
        ("simulate", REFERENCE, "--command", "chirp", "-o", "r.csv", "--set", "screw.csj=1"),
        "screw.csj: unknown value (did you mean screw.csj_Nm?)",
    ),
    (
        ("simulate", REFERENCE, "--command", "chirp", "-o", "r.csv", "--set", "screw.csj_Nm"),
        "--set screw.csj_Nm: no value: write --set section.field=value",
    ),
    (
        ("simulate", REFERENCE, "--command", "chirp", "-o", "r.csv", "--set", "screw.csj_Nm=999"),
        "--set screw.csj_Nm = 999.0: outside 0 .. 100 Nm: give a value inside",
    ),
    (
        ("simulate", REFERENCE, "--command", "chirp", "-o", "r.csv", "--set", "drive.mode=torque"),
        "--set drive.mode = torque: not a choice: use one of voltage, current",
    ),
    *(
        (
            ("simulate", REFERENCE, "--command", "chirp", "-o", "r.csv", "--set", f"timing.record_every_steps={value}"),
            f"--set timing.record_every_steps = {value}: not a whole number: give one in 1 .. ",
        )
        for value in ("inf", "-inf", "nan", "1.5")
    ),
    *(
        (
            ("simulate", REFERENCE, "--command", "chirp", "-o", "r.csv", "--set", f"search.initial_temperature_mm2s={value}"),
            f"--set search.initial_temperature_mm2s = {value}: outside ",
        )
        for value in ("inf", "nan")
    ),
    (("simulate", REFERENCE, "--command", "multisine:count=inf", "-o", "r.csv"), "command multisine: count=inf: not a finite number"),
    (("simulate", REFERENCE, "--command", "multisine:count=1e300", "-o", "r.csv"), "a value is outside its range"),
    (
        ("simulate", REFERENCE, "--command", "chirp:duration_s=1e308", "-o", "r.csv"),
        "command chirp: duration_s=1e+308: inf rows: ask for 1 to",
    ),
    (("effects", "--json", "new/e.json"), "new/e.json: there is no folder new: make it, or choose another place"),
    (
        ("simulate", REFERENCE, "--command", "chirp", "-o", "new/r.csv", "--json", "new/r.json"),
        "new/r.json: there is no folder new: make it, or choose another place",
    ),
    (
        ("simulate", REFERENCE, "--command", "chirp", "-o", "r.csv", "--noise", "position=1"),
        "--noise position=1: unknown column (did you mean position_mm?)",
    ),
    (("simulate", REFERENCE, "--command", "chirp", "-o", "r.csv", "--noise", "position_mm=x"), "--noise position_mm=x: not a number"),
    (
        ("simulate", REFERENCE, "--command", "chirp", "-o", "r.csv", "--noise", "position_mm=-1"),
        "--noise position_mm=-1: not a standard deviation",
    ),
    (
        ("simulate", REFERENCE, "--command", "chirp", "-o", "r.csv", "--set", "motor.inductance_H=1e-9"),
        "simulate: motor.inductance_H: so small that the machine answers in 1e-09 s: the step is too long for a time constant",
    ),
    (
        ("simulate", REFERENCE, "--command", "chirp", "-o", "r.csv", "--set", "screw.inertia_kgm2=1e-9"),
        "simulate: screw.inertia_kgm2: so small that the machine answers in 2.6e-07 s: the step is too long",
    ),
    (("simulate", REFERENCE, "--command", "chirp", "-o", "."), ".: is a folder: name a file"),
    (("compare", REFERENCE, "none.csv"), "none.csv: there is no such file; check the path"),
    (
        ("compare", RECORDINGS / "case_a.csv", RECORDINGS / "case_a.csv"),
        "case_a.csv: a recording where an actuator is wanted: give the actuator's TOML file first",
    ),
    (("compare", REFERENCE, REFERENCE), "reference.toml: "),
    (("identify", REFERENCE, "none.mat"), "none.mat: no such file or directory: check the path"),
    (("calibrate", REFERENCE, RECORDINGS / "healthy.csv", "-o", "n.toml", "--fit", "csj"), "csj: unknown value"),
    (
        ("effects", "stribek_friction"),
        "effect stribek_friction: unknown (did you mean stribeck_friction, position_friction or learned_friction?): ema effects lists all ",
    ),
    (("import", "emps", "none.mat", "-o", "emps"), "none.mat: no such file or directory: check the path"),
    (("report", "none.json", "-o", "p.html"), "none.json: no such file or directory: check the path"),
]


@pytest.mark.parametrize(("arguments", "message"), BAD, ids=[" ".join(str(part) for part in case[0][-2:]) for case in BAD])
def test_bad_input_ends_with_one_and_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[object, ...], message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    said = complaint(run_ema(*arguments))
    assert message in said
    assert list(tmp_path.iterdir()) == []


def test_nothing_is_overwritten(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("r.csv", "r.json", "a.h", "a.txt"):
        (tmp_path / name).write_text("mine", encoding="utf-8")
    for arguments in (
        ("simulate", REFERENCE, "--command", "chirp", "-o", "r.csv"),
        ("simulate", REFERENCE, "--command", "chirp", "-o", "new.csv", "--json", "r.json"),
        ("compare", REFERENCE, RECORDINGS / "case_a.csv", "--json", "r.json"),
        ("identify", REFERENCE, RECORDINGS / "case_a.csv", "--json", "r.json"),
        ("export", REFERENCE, "-o", "a.h"),
        ("export", REFERENCE, "-o", "new.h", "--flat", "a.txt"),
        ("effects", "--json", "r.json"),
    ):
        assert "exists already: choose another name or give --force" in complaint(run_ema(*arguments))
    assert all((tmp_path / name).read_text(encoding="utf-8") == "mine" for name in ("r.csv", "r.json", "a.h", "a.txt"))
    assert not (tmp_path / "new.csv").exists()
    assert not (tmp_path / "new.h").exists()
    assert run_ema("simulate", REFERENCE, "--command", "chirp", "-o", "r.csv", "--force").code == 0
    assert (tmp_path / "r.csv").read_text(encoding="utf-8") != "mine"


def test_outputs_are_kept_apart_from_inputs_and_from_each_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With --force, too: nothing that the command reads is overwritten, and no result by another."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.toml").write_bytes(REFERENCE.read_bytes())
    (tmp_path / "r.csv").write_bytes((RECORDINGS / "healthy.csv").read_bytes())
    (tmp_path / "link.csv").symlink_to("r.csv")
    (tmp_path / "i.json").write_text("{}", encoding="utf-8")
    (tmp_path / "record.csv").write_text("mine", encoding="utf-8")
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    for arguments, name in (
        (("simulate", "a.toml", "--command", "r.csv", "-o", "r.csv"), "r.csv"),
        (("simulate", "a.toml", "--command", "chirp", "-o", "a.toml"), "a.toml"),
        (("compare", "a.toml", "r.csv", "--json", "link.csv"), "link.csv"),
        (("calibrate", "a.toml", "r.csv", "-o", "a.toml"), "a.toml"),
        (("calibrate", "a.toml", "link.csv", "-o", "n.toml", "--json", "r.csv"), "r.csv"),
        (("identify", "a.toml", "r.csv", "--fitted", "./a.toml"), "./a.toml"),
        (("identify", "a.toml", RECORDINGS / "case_a.csv", "--healthy", "r.csv", "--json", "r.csv"), "r.csv"),
        (("export", "a.toml", "-o", "a.toml"), "a.toml"),
        (("report", "i.json", "-o", "i.json"), "i.json"),
        (("import", "emps", "record.csv", "-o", "."), "record.csv"),
    ):
        for force in ((), ("--force",)):
            assert (
                complaint(run_ema(*arguments, *force))
                == f"{name}: is read by this command and would be overwritten: choose another name for the output"
            )
    for arguments in (
        ("simulate", "a.toml", "--command", "chirp", "-o", "new", "--json", "new"),
        ("calibrate", "a.toml", "r.csv", "-o", "new", "--json", "new"),
        ("identify", "a.toml", "r.csv", "--fitted", "new", "--json", "./new"),
        ("export", "a.toml", "-o", "new", "--flat", "new"),
        ("report", "i.json", "-o", "new", "--json", "new"),
        ("demo", "-o", "d", "--json", "d/report.html"),
        ("import", "emps", "e.mat", "-o", "d", "--json", "d/record.csv"),
    ):
        assert "named for two outputs: give each its own name" in complaint(run_ema(*arguments))
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_results_are_json_and_the_folder_of_a_page_is_made(tmp_path: Path) -> None:
    target = tmp_path / "c.json"
    ran = run_ema("compare", REFERENCE, RECORDINGS / "case_a_noisy.csv", "--json", target)
    assert ran.code == 0, ran.err
    assert ran.err == ""
    result = json.loads(target.read_text(encoding="utf-8"))
    assert result["command"] == "compare"
    assert result["balances"]["mechanical"]["relative_percent"] > 10.0
    assert result["curves"]["period_s"] == pytest.approx(1e-3)
    assert len(result["curves"]["model"]["position_mm"]) == 10000
    assert ran.out.splitlines()[0] == result["sentence"]
    page = tmp_path / "new" / "deep" / "page.html"
    assert run_ema("report", target, "-o", page).code == 0
    assert page.stat().st_size > 10_000


def test_effects_are_listed_and_explained(tmp_path: Path) -> None:
    listed = run_ema("effects")
    for effect in load_definitions().effects:
        assert effect.name in listed.out
        one = run_ema("effects", effect.name)
        assert one.code == 0
        for value in effect.parameters:
            assert value.field in one.out
    run_ema("effects", "spring_load", "--json", tmp_path / "e.json")
    result = json.loads((tmp_path / "e.json").read_text(encoding="utf-8"))
    assert [effect["name"] for effect in result["effects"]] == ["spring_load"]
    assert result["effects"][0]["parameters"][0]["unit"] == "Nm/mm"
    assert result["effects"][0]["parameters"][0]["zero"] == 0.0


def test_simulate_sets_effects_and_reports_them(tmp_path: Path) -> None:
    ran = run_ema(
        "simulate",
        REFERENCE,
        "--command",
        "step:duration_s=1",
        "-o",
        tmp_path / "s.csv",
        "--set",
        "effects.spring_load.stiffness_Nm_per_mm=0.1",
        "--precision",
        "32",
    )
    assert ran.code == 0, ran.err
    text = (tmp_path / "s.csv").read_text(encoding="utf-8")
    assert "# Changed: effects.spring_load.stiffness_Nm_per_mm=0.1." in text
    assert "32 bit" in text
    assert len([line for line in text.splitlines() if not line.startswith("#")]) == 1001


def test_process_ends_with_the_code_and_without_a_traceback(tmp_path: Path) -> None:
    ran = subprocess.run(
        [sys.executable, "-m", "ema_tools", "compare", "none.toml", "none.csv"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=_environment(),
        check=False,
    )
    assert ran.returncode == 1
    assert ran.stderr == "ema: none.toml: no such file or directory: check the path\n"
    assert ran.stdout == ""


def test_output_may_be_cut_off(tmp_path: Path) -> None:
    ran = subprocess.run(
        f'"{sys.executable}" -m ema_tools effects | head -1',
        shell=True,
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=_environment(),
        check=False,
    )
    assert "Traceback" not in ran.stderr
    assert ran.stdout.count("\n") == 1


@pytest.mark.skipif(sys.platform == "win32", reason="needs a limit on the size of files")
@pytest.mark.parametrize("arguments", [("effects",), ("--help",), ("effects", "spring_load")])
def test_output_that_cannot_be_written_is_one_line(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    """Standard output is a file that may not grow, as on a full disk."""
    code = "import resource, runpy, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY)); sys.argv[0] = 'ema'; runpy.run_module('ema_tools', run_name='__main__')"
    with (tmp_path / "out.txt").open("w", encoding="utf-8") as full:
        ran = subprocess.run(
            [sys.executable, "-B", "-c", code, *arguments],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            cwd=tmp_path,
            env=_environment(),
            check=False,
        )
    assert ran.returncode == 1
    assert ran.stderr == "ema: standard output: file too large: make room or send it elsewhere\n"


def _environment() -> dict[str, str]:
    import os

    return {**os.environ, "PYTHONPATH": str(ROOT / "tools")}


def test_every_command_writes_json() -> None:
    for command in (*COMMANDS, "import emps"):
        if command != "import":
            assert "--json" in run_ema(*command.split(), "--help").out, command


@pytest.mark.parametrize(
    ("command", "args", "arguments", "healthy"),
    [
        ("identify", ("a", "r", "--healthy", "1", "2", "3", "--seed", "4"), ("a", "r"), ("1", "2", "3")),
        ("identify", ("a", "r", "--healthy", "1", "--healthy", "2"), ("a", "r"), ("1", "2")),
        ("identify", ("a", "--healthy", "1", "2", "r"), ("a", "r"), ("1", "2")),
        ("identify", ("--healthy=1", "--healthy=2", "a", "r"), ("a", "r"), ("1", "2")),
        ("identify", ("--healthy", "1", "--seed", "4", "a", "r"), ("a", "r"), ("1",)),
        ("diagnose", ("a", "r1", "r2", "--healthy", "1", "2"), ("a", ("r1", "r2")), ("1", "2")),
        ("diagnose", ("a", "--healthy", "1", "2", "--holdout", "h", "r1", "r2"), ("a", ("r1", "r2")), ("1", "2")),
        ("add", ("a", "stribeck", "-o", "n", "--healthy", "1", "2", "--fit", "r"), ("a", "stribeck", ()), ("1", "2")),
    ],
)
def test_healthy_takes_all_files_behind_it(
    command: str, args: tuple[str, ...], arguments: tuple[str | tuple[str, ...], ...], healthy: tuple[str, ...]
) -> None:
    """As a pattern that the shell expands; a second healthy file is never one of today."""
    known = cli.commands[command]
    context = known.make_context(command, list(args))
    taken = tuple(context.params[one.name] for one in known.params if isinstance(one, click.Argument) and one.name)
    assert taken == arguments
    assert context.params["healthy"] == healthy
