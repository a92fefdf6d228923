"""What the name of a column says: the kind of signal, whether it is asked for or measured, and whether it is one that is taken for a drive and is none."""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from ema_tools.data.tables.text import split_unit
from ema_tools.data.tables.units import Units

Role = Literal["", "asked", "actual"]
# What a column is besides its kind: of the electronics' supply, of one phase, along the field, of the pulses of a bridge, a load that another sensor measures, a controller's error.
Special = Literal["", "supply", "phase", "field", "duty", "cell", "load", "error"]

# What turns behind the gear.
_BEHIND = re.compile(r"\b(out|output|load|joint|link|abtrieb\w*|gelenk\w*|getriebe\w*)\b")
# What may stand behind a symbol of one letter.
_OF_SYMBOL = r"(ist|act|meas|soll|set|ref|cmd)"
# What names of signals look like, in the languages that makers write; the first that fits is taken.
_WORDS: Sequence[tuple[str, str]] = (
    ("time", r"\b(time|t|zeit|timestamp|temps|tiempo|clock|seconds|datetime)\b"),
    ("temperature", r"temp(?!s)|t ?mot\b|wicklung|winding.*t"),
    # the current that makes the torque speaks of both
    ("current", r"(torque|moment\w*)[ -](\w+ ){0,2}(current|curr|strom)\b|momentenstrom|\bi ?q\b"),
    ("torque", rf"torque|moment|drehmoment|couple|\btr?q\b|^m( ?(mot|{_OF_SYMBOL}))? *$|\btau\b"),
    ("force", rf"force|kraft|thrust|load ?cell|\bf ?{_OF_SYMBOL}\b"),
    ("current", rf"current(?! (pos|vel|speed))|strom|courant|\bi ?[aq]\b|\bi ?(mot|{_OF_SYMBOL})\b|\bamps?\b|\bcurr?\b|\bi\b|corriente"),
    ("voltage", r"volt|spannung|tension|\bu ?(mot|[aq])?\b|\bv ?(mot|q)\b"),
    ("speed", rf"speed|veloc|drehzahl|geschw|\bn ?(mot)?\b|vitesse|omega|\brpm\b|\bvel\b|\bw\b|\bv ?(rod|{_OF_SYMBOL})\b"),
    ("angle", r"angle|winkel|theta|\bphi\b|rotor"),
    ("position", r"pos|weg|stroke|travel|displac|lage|encoder|\bx\b|\bq\b|\bqm\b|\by\b|deplac"),
)
_ASKED = re.compile(
    r"command|demand|refer|\bref\b|target|(?<!data )\bset\b|set.?point|soll|\bcmd|desired|\bqg\b|asked|consigne|vorgabe|führungs|\bziel(?!on)|\btgt\b"
)
_ACTUAL = re.compile(r"\bact(?!uator|iv)|actual|\bmeas|measured|\bist|istwert|\bmess|gemessen|feedback|\bfb\b|\bfdbk\b|\bfbk\b")
_SUPPLY = re.compile(
    r"\b[vui] ?bat|batter|\bakku|supply|versorgung|speise|\b([vui] ?)?bus\b|dc ?link|link voltage|\bdc ?bus|\b[vui] ?dc\b|\bdc [vui]\b|zwischenkreis"
    r"|\b[ui]? ?zk\b|\bv ?(cc|dd)\b|\bmains\b|\bnetz|\bpsu\b|alimentation"
)
_DUTY = re.compile(r"\bduty|\bpwm|tastgrad|tastverh|aussteuer|modulation")
_FIELD = re.compile(r"\bi ?d\b|flux.*current|field.*current|feldstrom|magnetisierungsstrom|magneti[sz]ing")
_ERROR = re.compile(r"\berr(or)?\b(?! ?(code|number|id|flag|count|bit|word))|deviation|abweichung|schlepp|\blag\b|residual")
_CELL = re.compile(
    r"load ?cell|kraftmess|kraftaufnehmer|messdose|w(ä|ae)gezelle|\bdms\b|external|extern|process|prozess|\bload\b|\blast(kraft|moment)?\b"
)
_SURE_CELL = re.compile(r"load ?cell|kraftmess|kraftaufnehmer|messdose|w(ä|ae)gezelle|external|extern")
_LOAD = re.compile(r"disturb|\bst(ö|oe)r")
# w beside what it is the setpoint of; alone, or of a motor, it is a speed.
_SETPOINT_W = re.compile(
    r"\b(pos\w*|lage|weg|strom|iq?|current|drehzahl|speed|n|x) w$|^w (pos\w*|lage|weg|strom|iq?|current|drehzahl|n|x)\b"
)
_PHASES = (
    re.compile(r"\b[iuv] ?(?:l ?)?(alpha|beta|[abcuvwrst123])\b"),
    re.compile(r"(?:current|strom|curr?|amps?|volt(?:age)?s?|spannung) ?(?:phase ?)?(?:l ?)?([abcuvw123])\b"),
    re.compile(r"\bphase[n]? ?(?:strom|current|curr|spannung|voltage)? ?(?:l ?)?([abcuvwrst123])\b"),
)
_OF_PHASE = re.compile(r"phase[n]? ?(strom|current|curr|spannung|voltage)|(current|strom|voltage|spannung).*phase")
# Names of phases that belong together, and how many of them show that a name is one: two letters of three are no chance, numbers may be those of motors.
_SETS: Sequence[tuple[frozenset[str], int]] = (
    (frozenset("abc"), 2),
    (frozenset("uvw"), 2),
    (frozenset("rst"), 3),
    (frozenset("123"), 3),
    (frozenset({"alpha", "beta"}), 2),
)


@dataclass(frozen=True)
class SpokenName:
    """What a name says: `kind` of signal (empty where it says none), whether it is asked for or measured, what else it is; `phase`: A or V and the phase that it may be of; `behind` a gear."""

    kind: str = ""
    role: Role = ""
    special: Special = ""
    phase: str = ""
    behind: bool = False


def spoken(name: str, unit_suffix: str, units: Units, share: bool = False) -> SpokenName:
    """Read a name. `unit_suffix`: of the dimension of the column's unit, empty where it has none; `share`: the unit is one of a nominal value."""
    text = _plain(name, units)
    kind = next((word for word, pattern in _WORDS if re.search(pattern, text)), "")
    role = _role(text)
    phase = next((found[1] for found in (pattern.search(text) for pattern in _PHASES) if found), "")
    if (kind, unit_suffix) not in (
        ("current", "A"),
        ("current", ""),
        ("", "A"),
        ("", ""),
        ("voltage", "V"),
        ("voltage", ""),
        ("", "V"),
        ("speed", "V"),
    ):
        phase = ""
    phase = phase and ("V" if kind == "voltage" or unit_suffix == "V" else "A") + phase
    return SpokenName(kind, role, _special(text, kind, unit_suffix, share), phase, bool(_BEHIND.search(text)))


def is_setpoint_symbol(name: str, units: Units) -> bool:
    """Whether a name is w alone, the setpoint beside an x as controllers call it; alone it is a speed."""
    return _plain(name, units) == "w"


def is_value_symbol(name: str, units: Units) -> bool:
    """Whether a name is x alone."""
    return _plain(name, units) == "x"


def phases_of(names: Mapping[int, SpokenName]) -> frozenset[int]:
    """Which columns are currents or voltages of phases, by number: several that belong together, or what is called so."""
    found = {number for number, one in names.items() if one.special == "phase"}
    for quantity, (letters, least) in itertools.product("AV", _SETS):
        members = {number: one.phase for number, one in names.items() if one.phase[:1] == quantity and one.phase[1:] in letters}
        if len(set(members.values())) >= least:
            found |= set(members)
    return frozenset(found)


def _plain(name: str, units: Units) -> str:
    """A name without its unit, in small letters, its words apart."""
    text = re.sub(r"([a-zäöü])([A-ZÄÖÜ])|([A-Z])(?=[A-Z][a-z]{2})", r"\1\3 \2", split_unit(name, units)[0])
    text = re.sub(r"[\[({].*?[\])}]", " ", text)
    text = re.sub(r"[_.\-/:]", " ", text).casefold()
    # nsoll, iqref: a symbol and what it is of
    text = re.sub(rf"\b(i[abcduvwq]?|u[dq]?|[nxvmpfswq]){_OF_SYMBOL}\b", r"\1 \2", text)
    return " ".join(text.split())


def _role(text: str) -> Role:
    """Asked for or measured: what is said last counts, the first is often the name of a group."""
    asked, actual = ([found.start() for found in pattern.finditer(text)] for pattern in (_ASKED, _ACTUAL))
    if _SETPOINT_W.search(text):
        asked.append(len(text))
    if not asked and not actual:
        return ""
    return "asked" if max(asked, default=-1) > max(actual, default=-1) else "actual"


def _special(text: str, kind: str, suffix: str, share: bool) -> Special:
    """What is none of what its kind says."""
    electric = kind in ("voltage", "current") or (kind == "" and suffix in ("V", "A", ""))
    if _SUPPLY.search(text) and electric and suffix in ("V", "A", "") and not share:
        return "supply"
    if _DUTY.search(text) and suffix not in ("V", "A"):
        return "duty"
    if _ERROR.search(text) and kind != "time":
        return "error"
    if electric and _OF_PHASE.search(text):
        return "phase"
    if kind in ("current", "") and suffix in ("A", "") and _FIELD.search(text) and (kind or suffix):
        return "field"
    mechanical = suffix in ("N", "Nm") or (kind in ("force", "torque", "") and suffix == "")
    if mechanical and not share:
        if _LOAD.search(text):
            return "load"
        if _CELL.search(text) and (kind or suffix or _SURE_CELL.search(text)):
            return "cell"
    return ""
