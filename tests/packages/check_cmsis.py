"""The module as a CMSIS pack: made by one command, twice to the same bytes, and the outside project built from the files that its description lists."""

from __future__ import annotations

import argparse
import sys
import zipfile
from xml.etree import ElementTree

from outside import bits, bits_of_sources, expect, main, run, version_of

# Children of a package in their order, those that a pack must have (Open-CMSIS-Pack, PACK.xsd).
ORDER = ("vendor", "name", "description", "url", "license", "releases", "keywords", "components")


def check(arguments: argparse.Namespace) -> str:
    """The whole way; says what was run."""
    root, work = arguments.root, arguments.work
    version = version_of(root)
    for folder in ("one", "two"):
        run([sys.executable, root / "port/cmsis_pack/make_pack.py", "-o", work / folder], work)
    pack = work / f"one/EMA.ema.{version}.pack"
    expect(pack.is_file(), f"no {pack.name}")
    expect(pack.read_bytes() == (work / f"two/{pack.name}").read_bytes(), "the same sources make other bytes")
    taken = work / "taken"
    with zipfile.ZipFile(pack) as held:
        held.extractall(taken)
    package = ElementTree.parse(taken / "EMA.ema.pdsc").getroot()
    expect(
        tuple(child.tag for child in package) == ORDER, f"EMA.ema.pdsc: {[child.tag for child in package]}, in this order wanted: {ORDER}"
    )
    releases = [one.get("version") for one in package.iter("release")]
    expect(releases[0] == version, f"EMA.ema.pdsc: the last release is {releases[0]}, not {version}")
    expect((taken / (package.findtext("license") or "-")).is_file(), "EMA.ema.pdsc: its licence is not in the pack")
    files = {
        kind: [taken / (one.get("name") or "") for one in package.iter("file") if one.get("category") == kind]
        for kind in ("sourceC", "include")
    }
    lost = [path for paths in files.values() for path in paths if not path.exists()]
    expect(not lost, f"EMA.ema.pdsc lists {lost[:1]}, which is not in the pack")
    built = bits(work, files["sourceC"], files["include"], ["-ffp-contract=off", "-fno-math-errno"])
    expect(built == bits_of_sources(root, work), "from the CMSIS pack the bits are others")
    return f"{pack.name}, twice the same, and the outside project built from the files that it lists"


if __name__ == "__main__":
    sys.exit(main("cmsis", check))
