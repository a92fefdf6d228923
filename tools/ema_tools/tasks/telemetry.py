"""Results that firmware packed by `ema_result_pack`, read on the ground. Layout: docs/FIRMWARE.md, "Results as telemetry"."""

from __future__ import annotations

import math
import struct
import zlib
from pathlib import Path

from ema_tools.base.errors import InputError
from ema_tools.base.files import reason
from ema_tools.library.definitions import load_definitions
from ema_tools.plant.native import FINDINGS, OUTCOMES, REASONS, VERDICTS, checked_schema
from ema_tools.results.telemetry import PackedFinding, PackedValue, Packet, TelemetryResult

_HEAD = struct.Struct("<4s2H")  # mark, version, bytes
_BODY = struct.Struct("<4I4BIQQ8x6I5f4BQ7f")  # what ema_result_t and ema_finding_t hold but the values
_VALUE = struct.Struct("<2H5f")  # id, flags, estimate, std, bias, shift, half of the interval
_CRC = struct.Struct("<I")
_MARK = b"EMAT"
_VERSION = 1  # of the packet's layout: EMA_TELEMETRY_VERSION [layout]
_VALUES = 4  # EMA_IDENTIFIED_MAX [layout]
_BYTES = _HEAD.size + _BODY.size + _VALUES * _VALUE.size + _CRC.size
_ADEQUATE, _FINDING, _AT_BOUND = 1, 2, 1  # bits of the flags [layout]
_SEARCH = ("evaluations", "accepted", "accepted_uphill", "from_quadratic", "reannealed", "not_finite")


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _effect(place: int) -> str | None:
    effects = load_definitions().effects
    return effects[place].name if place < len(effects) else None


def _value(data: bytes, offset: int) -> PackedValue:
    number, flags, *reals = _VALUE.unpack_from(data, offset)
    estimate, std, bias, shift, half = map(_finite, reals)
    return PackedValue(load_definitions().value_names[number], estimate, std, bias, half, shift, bool(flags & _AT_BOUND))


def _packet(data: bytes) -> Packet:
    """One packet whose mark, version, length and checksum are right. Raises InputError, without a place, for one of other lists."""
    numbers = _BODY.unpack_from(data, _HEAD.size)
    software, schema, configuration, reasons, verdict, outcome, flags, count, evaluations, model_steps, random = numbers[:11]
    search, (before, after, rms, correlation, outside) = numbers[11:17], map(_finite, numbers[17:22])
    kind, effect, runner_up, _, alike = numbers[22:27]
    score, runner_up_score, limit, size, energy = map(_finite, numbers[27:32])
    if schema != checked_schema():
        raise InputError("made for other lists of values than those of these tools: read it with the tools of that module")
    known = load_definitions()
    finding = None
    if flags & _FINDING:
        named = tuple(one.name for place, one in enumerate(known.effects) if alike >> place & 1)
        finding = PackedFinding(FINDINGS[kind], _effect(effect), _effect(runner_up), named, size, score, runner_up_score, limit, energy)
    values = tuple(_value(data, _HEAD.size + _BODY.size + index * _VALUE.size) for index in range(count))
    return Packet(
        software=f"{software >> 16}.{software >> 8 & 255}.{software & 255}",
        configuration=f"{configuration:08x}",
        verdict=VERDICTS[verdict],
        reasons=tuple(text for bit, text in REASONS.items() if reasons & bit),
        adequate=bool(flags & _ADEQUATE),
        outcome=OUTCOMES[outcome],
        values=values,
        finding=finding,
        objective_before_mm2s=before,
        objective_after_mm2s=after,
        residual_rms_mm=rms,
        residual_correlation=correlation,
        outside_ratio=outside,
        evaluations=evaluations,
        model_steps=model_steps,
        search=dict(zip(_SEARCH, search, strict=True)),
        random=f"{random:016x}",
    )


def _problem(data: bytes) -> str | None:
    """What is wrong with a packet before its content is looked at."""
    if len(data) < _BYTES:
        return f"{len(data)} bytes where a packet has {_BYTES}: it is cut off"
    mark, version, size = _HEAD.unpack_from(data)
    if mark != _MARK:
        return "no packet begins there: give the file as the packets were written, without anything between them"
    if (version, size) != (_VERSION, _BYTES):
        return f"of version {version}: read it with the tools of that module"
    if zlib.crc32(data[: -_CRC.size]) != _CRC.unpack_from(data, _BYTES - _CRC.size)[0]:
        return "its checksum is another: it was damaged on the way"
    return None


def telemetry(file: str | Path) -> TelemetryResult:
    """The packets of a file. Raises InputError that names the packet and what is wrong with it."""
    try:
        data = Path(file).read_bytes()
    except OSError as error:
        raise InputError(f"{file}: {reason(error)}: check the path") from None
    if not data:
        raise InputError(f"{file}: the file is empty: name one with packets of ema_result_pack")
    packets: list[Packet] = []
    for offset in range(0, len(data), _BYTES):
        one = data[offset : offset + _BYTES]
        problem = _problem(one)
        try:
            if problem is not None:
                raise InputError(problem)
            packets.append(_packet(one))
        except InputError as error:
            raise InputError(f"{file}: packet {len(packets) + 1}: {error}") from None
        except (IndexError, KeyError):
            raise InputError(
                f"{file}: packet {len(packets) + 1}: a number in it means nothing: it was not packed by ema_result_pack"
            ) from None
    return TelemetryResult("telemetry", str(file), tuple(packets))
