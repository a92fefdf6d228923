"""The configuration as data: images that the module reads, headers that refuse other lists, and packed results that are read on the ground."""

from __future__ import annotations

import json
import os
import re
import shutil
import struct
import subprocess
import zlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ema_tools import __version__
from ema_tools.base.errors import InputError, LibraryError
from ema_tools.data.actuator import Actuator, read_actuator, reference_actuator
from ema_tools.library.definitions import Definitions, Parameter, library_folder, load_definitions
from ema_tools.library.schema import main as write_schema
from ema_tools.library.schema import schema_of, with_schema
from ema_tools.plant import native
from ema_tools.plant.signatures_header import read_signatures
from ema_tools.tasks.export import header_text
from ema_tools.tasks.image import Unit, identity, image_bytes, read_image, unit_of
from support import EXPORTED, RECORDINGS, REFERENCE, ROOT, complaint, run_ema

UNIT = RECORDINGS / "unit" / "unit.toml"
TABLE = EXPORTED / "ace_unit_signatures.h"
SCHEMA = ROOT / "include" / "ema" / "detail" / "ema_schema.h"
PACKET_BYTES = 240

# Reads the image on standard input, tells its units, and packs a result of the last into the file that is named.
PROGRAM = """
#include <math.h>
#include <stdio.h>
#include "ema/ema.h"
static union { uint32_t word; uint8_t bytes[200000]; } image;
static ema_real buffer[64];
int main(int argc, char* argv[])
{
    const size_t length = fread(image.bytes, 1, sizeof image.bytes, stdin);
    printf("check %d\\n", (int)ema_image_check(image.bytes, length));
    ema_unit_t unit = {0};
    for (uint32_t place = 0; place < ema_image_count(image.bytes, length); ++place) {
        const ema_image_status_t status = ema_image_open(image.bytes, length, place, &unit);
        if (status != EMA_IMAGE_OK) {
            return (int)status;
        }
        printf("unit %s %08lx %08lx %.9g %d\\n", unit.name, (unsigned long)unit.identity, (unsigned long)ema_actuator_identity(unit.actuator),
               (double)unit.actuator->params.csj_Nm, (int)unit.has_signatures);
        ema_record_config_t kept = {.buffer = buffer, .buffer_bytes = sizeof buffer, .format = EMA_RECORD_REAL};
        kept.keep[EMA_CHANNEL_CURRENT] = true;
        static ema_guarded_t guarded;
        static ema_session_config_t config;
        (void)ema_session_config_default(&config, unit.actuator, &kept);
        (void)ema_session_config_day(&config);
        printf("guarded %d\\n", (int)ema_guarded_init(&guarded, &config, unit.has_signatures ? &unit.signatures : NULL));
        ema_result_t result = {0};
        ema_finding_t finding = {0};
        result.identified_count = config.identified_count;
        for (uint32_t k = 0; k < result.identified_count; ++k) {
            result.identified[k] = (ema_estimate_t){.estimate = 0.5F + (float)k, .today = 0.5F, .std = 0.25F, .bias = 0.125F, .scatter_percent = 1.0F, .shift_percent = 12.5F, .at_bound = k == 1U};
        }
        result.identified[1].std = (ema_real)NAN;
        result.objective_after = 3.5F;
        result.evaluations = 123U;
        result.model_steps = 5000000000U;
        result.outcome = EMA_OUTCOME_BUDGET;
        result.verdict = EMA_VERDICT_UNDECIDED;
        result.reasons = (uint32_t)EMA_REASON_EFFECT | (uint32_t)EMA_REASON_AT_BOUND;
        result.random.state = UINT64_C(0x0123456789abcdef);
        finding.kind = EMA_FINDING_MISSING;
        finding.effect = EMA_EFFECT_ID_spring_load;
        finding.runner_up = EMA_EFFECT_COUNT;
        finding.alike = UINT64_C(1) << EMA_EFFECT_ID_spring_load;
        finding.size = 0.75F;
        uint8_t packet[EMA_TELEMETRY_BYTES];
        if (ema_result_pack(&config, &result, unit.has_signatures ? &finding : NULL, packet) != EMA_OK) {
            return 100;
        }
        FILE* const file = fopen(argv[argc - 1], "ab");
        if (file == NULL || fwrite(packet, 1, sizeof packet, file) != sizeof packet || fclose(file) != 0) {
            return 101;
        }
    }
    return 0;
}
"""


def compiler_named() -> str:
    """The C compiler; the test is skipped without one."""
    compiler = os.environ.get("CC") or shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler: install one or name it in CC")
    return str(compiler)


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Callable[[bytes, Path], list[list[str]]]:
    """Lets the module read an image, and pack a result of each unit behind the packets of a file."""
    compiler, archive, folder = compiler_named(), library_folder() / "libema.a", tmp_path_factory.mktemp("image")
    if not archive.is_file():
        pytest.skip("libema.a is not built: build the project")
    (folder / "main.c").write_text(PROGRAM, encoding="utf-8")
    command = [compiler, "-std=c11", "-Wall", "-Wextra", "-Werror", f"-I{ROOT / 'include'}", "main.c", str(archive), "-lm", "-o", "main"]
    subprocess.run(command, cwd=folder, check=True)

    def run(image: bytes, packets: Path) -> list[list[str]]:
        done = subprocess.run([folder / "main", packets], input=image, capture_output=True, check=True)
        return [line.split(" ") for line in done.stdout.decode().splitlines()]

    return run


def guarded_unit() -> tuple[Actuator, Unit]:
    """The recorded unit with its table."""
    actuator = read_actuator(UNIT)
    return actuator, unit_of(actuator, read_signatures(TABLE), "a unit")


def test_the_module_reads_what_the_tools_write(program: Callable[[bytes, Path], list[list[str]]], tmp_path: Path) -> None:
    other = reference_actuator().changed({"screw.csj_Nm": 0.1 + 0.2})
    actuator, unit = guarded_unit()
    told = program(image_bytes([unit_of(other, name="first"), unit]), tmp_path / "p.bin")
    assert told == [
        ["check", "0"],
        ["unit", "first", *[f"{identity(other):08x}"] * 2, f"{np.float32(0.1 + 0.2):.9g}", "0"],
        ["guarded", "0"],
        ["unit", "a", "unit", *[f"{identity(actuator):08x}"] * 2, f"{np.float32(actuator['screw.csj_Nm']):.9g}", "1"],
        ["guarded", "0"],
    ]


def test_the_exported_image_is_that_of_the_exported_table() -> None:
    held = [unit_of(read_actuator(REFERENCE)), replace(guarded_unit()[1], name="unit")]
    assert (EXPORTED / "ace_units.bin").read_bytes() == image_bytes(held)


def test_an_image_read_back_is_its_units(tmp_path: Path) -> None:
    units = [unit_of(reference_actuator(), name="one"), guarded_unit()[1]]
    (tmp_path / "a.bin").write_bytes(image_bytes(units))
    assert read_image(tmp_path / "a.bin") == units


def test_export_writes_images_and_joins_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    ran = run_ema("export", REFERENCE, "--image", "one.bin", "--json", "e.json")
    assert ran.code == 0, ran.err
    known = read_actuator(REFERENCE)
    assert ran.out == f"one.bin written: {os.path.getsize('one.bin') / 1024:.1f} KiB, reference actuator {identity(known):08x}\n"
    told = json.loads(Path("e.json").read_text(encoding="utf-8"))
    assert (told["header"], told["image"]["file"], told["image"]["bytes"]) == (None, "one.bin", os.path.getsize("one.bin"))
    assert told["image"]["units"] == [{"name": "reference actuator", "identity": f"{identity(known):08x}", "signatures_bytes": 0}]
    assert int(told["image"]["schema"], 16) == schema_of(load_definitions())

    asked = ("export", UNIT, "-o", "data.h", "--image", "two.bin", "--beside", "one.bin", "--table", TABLE, "--name", "left aileron")
    assert run_ema(*asked).code == 0
    assert Path("data.h").read_text(encoding="utf-8") == header_text(read_actuator(UNIT))
    assert [unit.name for unit in read_image("two.bin")] == ["reference actuator", "left aileron"]
    known.changed({"screw.csj_Nm": 0.2}).write("new.toml")
    assert run_ema("export", "new.toml", "--image", "three.bin", "--beside", "two.bin").code == 0
    units = read_image("three.bin")
    assert [unit.name for unit in units] == ["reference actuator", "left aileron"]
    assert units[0].identity == identity(read_actuator("new.toml")) and units[1] == read_image("two.bin")[1]


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("-o", "a.h", "--name", "x"),
        ("-o", "a.h", "--table", "t.h"),
        ("-o", "a.h", "--beside", "b.bin"),
        ("-o", "a.h", "--healthy", "h.csv"),
        ("--image", "a.bin", "--table", "t.h", "--signatures", "s.h"),
        ("--image", "a.bin", "--table", "t.h", "--healthy", "h.csv"),
    ],
)
def test_options_that_do_not_go_together(arguments: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    ran = run_ema("export", REFERENCE, *arguments)
    assert ran.code == 2 and "Usage: ema export" in ran.err
    assert not list(tmp_path.iterdir())


def test_what_serves_no_image_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("", "x" * 32, "é" * 16, "a\tb"):
        message = complaint(run_ema("export", REFERENCE, "--image", "a.bin", "--name", name or "\n"))
        assert "no name for a unit: give one of 1 to 31 bytes with --name" in message
    message = complaint(run_ema("export", REFERENCE, "--image", "a.bin", "--table", TABLE))
    assert message == f"{TABLE}: its signatures belong to another actuator: make them for this one with --healthy"
    assert complaint(run_ema("export", REFERENCE, "--image", "a.bin", "--beside", "none.bin")).startswith("none.bin: ")
    Path("a.bin").write_text("mine", encoding="utf-8")
    assert "exists already" in complaint(run_ema("export", REFERENCE, "--image", "a.bin"))
    assert "is read by this command" in complaint(run_ema("export", REFERENCE, "--image", "a.bin", "--beside", "a.bin", "--force"))
    assert [path.name for path in tmp_path.iterdir()] == ["a.bin"]


def test_images_that_are_stale_cut_off_or_damaged_are_refused(tmp_path: Path) -> None:
    good = image_bytes([unit_of(reference_actuator())])

    def sealed(place: int, value: int) -> bytes:
        body = good[:place] + struct.pack("<I", value) + good[place + 4 : -4]
        return body + struct.pack("<I", zlib.crc32(body))

    damaged = "of another version, cut off or damaged: export it again"
    other = "made for other lists of values than those of this module: export it again"
    none = "no image: name one that `ema export --image` wrote"
    spoilt = [(b"", none), (b"hello" * 20, none), (good[:20], none), (good[:-1], damaged), (good + b"\0", damaged)]
    spoilt += [(good[:300] + bytes([good[300] ^ 1]) + good[301:], damaged), (sealed(4, 0x04030201), damaged), (sealed(8, 2), damaged)]
    spoilt += [(sealed(16, schema_of(load_definitions()) ^ 1), other)]
    for data, why in spoilt:
        (tmp_path / "a.bin").write_bytes(data)
        with pytest.raises(InputError, match=re.escape(f"a.bin: {why}")):
            read_image(tmp_path / "a.bin")


def changed_lists() -> dict[str, Definitions]:
    """The lists with one row more, less, elsewhere or otherwise."""
    known = load_definitions()
    first, second, *rest = known.parameters
    effect, *effects = known.effects
    more = Parameter("control", "new_s", 0.0, 0.0, 1.0, "new")
    fewer_values = replace(effect, parameters=effect.parameters[:-1])
    return {
        "a parameter more": replace(known, parameters=(*known.parameters, more)),
        "a parameter less": replace(known, parameters=known.parameters[1:]),
        "two parameters in another order": replace(known, parameters=(second, first, *rest)),
        "a parameter of another name": replace(known, parameters=(replace(first, field="other"), second, *rest)),
        "an option that is a number": replace(known, parameters=(replace(first, is_option=not first.is_option), second, *rest)),
        "an effect more": replace(known, effects=(*known.effects, replace(effect, name="new"))),
        "an effect less": replace(known, effects=tuple(effects)),
        "two effects in another order": replace(known, effects=(effects[0], effect, *effects[1:])),
        "a value less": replace(known, effects=(fewer_values, *effects)),
    }


def test_every_change_of_the_lists_has_another_number() -> None:
    numbers = {name: schema_of(known) for name, known in changed_lists().items()}
    assert len({*numbers.values(), schema_of(load_definitions())}) == len(numbers) + 1
    ranges = replace(load_definitions(), parameters=tuple(replace(row, upper=row.upper + 1.0) for row in load_definitions().parameters))
    assert schema_of(ranges) == schema_of(load_definitions())


def test_the_header_has_the_number_of_the_lists(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text, number = SCHEMA.read_text(encoding="utf-8"), schema_of(load_definitions())
    assert with_schema(text, number) == text, "run cmake --build build --target written"
    assert native.checked_schema() == number
    (tmp_path / "s.h").write_text(with_schema(text, 0), encoding="utf-8")
    monkeypatch.setattr("sys.argv", ["schema", str(tmp_path / "s.h")])
    assert write_schema() == 0
    assert (tmp_path / "s.h").read_text(encoding="utf-8") == text
    with pytest.raises(ValueError, match="restore it"):
        with_schema("nothing", 0)


def test_libraries_whose_number_is_not_that_of_their_lists_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(native, "schema_of", lambda _known: 1)
    with pytest.raises(LibraryError, match="build the project again"):
        native.checked_schema()


def compiled(folder: Path, header: str, include: Path, *flags: str) -> subprocess.CompletedProcess[str]:
    """The compiler's run over an exported header."""
    (folder / "a.h").write_text(header, encoding="utf-8")
    (folder / "a.c").write_text(
        '#include "a.h"\nconst ema_actuator_t* seen(void);\nconst ema_actuator_t* seen(void) { return &EMA_ACTUATOR; }\n'
    )
    command = [compiler_named(), "-std=c11", "-pedantic-errors", "-Wall", "-fsyntax-only", f"-I{include}", *flags, "a.c"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def test_a_header_of_other_lists_does_not_compile(tmp_path: Path) -> None:
    header = header_text(reference_actuator())
    assert compiled(tmp_path, header, ROOT / "include").returncode == 0
    shutil.copytree(ROOT / "include", tmp_path / "include")
    rows = tmp_path / "include" / "ema" / "ema_params.def"
    row = 'EMA_PARAM(screw, new_s, 0.0, 0.0, 1.0, "new")\n'
    rows.write_text(
        rows.read_text(encoding="utf-8").replace("EMA_PARAM(screw, lead_mm", row + "EMA_PARAM(screw, lead_mm"), encoding="utf-8"
    )
    # without the number it would be taken, the new value zero
    assert compiled(tmp_path, header, tmp_path / "include").returncode == 0
    grown = tmp_path / "include" / "ema" / "detail" / "ema_schema.h"
    grown.write_text(with_schema(grown.read_text(encoding="utf-8"), schema_of(changed_lists()["a parameter more"])), encoding="utf-8")
    for header_of_it in (header, (TABLE.read_text(encoding="utf-8") + header)):
        ran = compiled(tmp_path, header_of_it, tmp_path / "include")
        assert ran.returncode != 0
        assert "made for other lists of values than those of this module: export it again: ema export" in ran.stderr
    own = compiled(tmp_path, header, ROOT / "include", f'-DEMA_OWN_EFFECTS="{ROOT / "examples" / "own_effect" / "own_effects.def"}"')
    assert own.returncode != 0 and "build with CMake, or define EMA_CONFIG_SCHEMA" in own.stderr


def test_packed_results_are_read(program: Callable[[bytes, Path], list[list[str]]], tmp_path: Path) -> None:
    actuator, unit = guarded_unit()
    image, packets = image_bytes([unit_of(reference_actuator(), name="first"), unit]), tmp_path / "p.bin"
    program(image, packets)
    ran = run_ema("telemetry", packets, "--json", tmp_path / "t.json")
    assert ran.code == 0, ran.err
    told = json.loads((tmp_path / "t.json").read_text(encoding="utf-8"))
    first, second = told["packets"]
    assert first["configuration"] == f"{identity(reference_actuator()):08x}" and first["finding"] is None
    assert [value["name"] for value in first["values"]] == ["screw.csj_Nm", "screw.blk_mm"]
    assert second["configuration"] == f"{identity(actuator):08x}" and second["software"] == __version__
    assert (second["verdict"], second["adequate"], second["outcome"]) == ("undecided", False, "budget")
    assert second["reasons"] == [text for text in native.REASONS.values() if "lies on a bound" in text or "table of signatures" in text]
    names = ["screw.csj_Nm", "screw.blk_mm", "screw.viscous_Nm_s_per_rad", "motor.resistance_ohm"]
    assert [value["name"] for value in second["values"]] == names
    assert [value["at_bound"] for value in second["values"]] == [False, True, False, False]
    csj = second["values"][0]
    assert (csj["estimate"], csj["std"], csj["bias"], csj["shift_percent"]) == (0.5, 0.25, 0.125, 12.5)
    assert csj["half_95"] > 1.96 * np.hypot(0.25, 0.125) * 0.999
    assert second["values"][1]["std"] is None
    assert (second["objective_after_mm2s"], second["evaluations"], second["model_steps"]) == (3.5, 123, 5000000000)
    assert second["random"] == "0123456789abcdef"
    finding = second["finding"]
    assert (finding["kind"], finding["effect"], finding["runner_up"], finding["alike"]) == ("missing", "spring_load", None, ["spring_load"])
    assert finding["size"] == 0.75
    assert f"Packet 2: configuration {second['configuration']}, module {__version__}" in ran.out
    assert "The table of signatures says: missing, spring_load." in ran.out and "motor.resistance_ohm" in ran.out


def test_packets_that_are_none_are_refused_by_number(program: Callable[[bytes, Path], list[list[str]]], tmp_path: Path) -> None:
    packets = tmp_path / "p.bin"
    program(image_bytes([unit_of(reference_actuator(), name="first"), guarded_unit()[1]]), packets)
    good = packets.read_bytes()
    assert len(good) == 2 * PACKET_BYTES

    def sealed(place: int, value: int) -> bytes:
        body = bytearray(good[PACKET_BYTES:-4])
        body[place] = value
        return good[:PACKET_BYTES] + bytes(body) + struct.pack("<I", zlib.crc32(body))

    for data, why in (
        (good[:-1], "packet 2: 239 bytes where a packet has 240: it is cut off"),
        (good[:PACKET_BYTES] + b"x" * PACKET_BYTES, "packet 2: no packet begins there"),
        (good[:-30] + bytes([good[-30] ^ 4]) + good[-29:], "packet 2: its checksum is another"),
        (sealed(4, 2), "packet 2: of version 2: read it with the tools of that module"),
        (sealed(12, good[PACKET_BYTES + 12] ^ 1), "packet 2: made for other lists of values"),
        (sealed(24, 9), "packet 2: a number in it means nothing"),
        (sealed(100, 9), "packet 2: a number in it means nothing"),
        (sealed(141, 255), "packet 2: a number in it means nothing"),
        (b"", "the file is empty"),
    ):
        packets.write_bytes(data)
        assert complaint(run_ema("telemetry", packets)).startswith(f"{packets}: {why}")
    assert complaint(run_ema("telemetry", tmp_path / "none")).startswith(f"{tmp_path / 'none'}: ")


def test_the_module_has_the_tools_version() -> None:
    version = native.module_version()
    assert f"{version >> 16}.{version >> 8 & 255}.{version & 255}" == __version__
