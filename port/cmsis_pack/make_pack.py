"""`python3 port/cmsis_pack/make_pack.py -o FOLDER`: the module as a CMSIS pack, EMA.ema.VERSION.pack, with its description inside; the standard library is all it needs.

The description follows the CMSIS-Pack format (Open-CMSIS-Pack, schema 1.7). What CMake's list of sources holds is in it: the C files, the public headers, and the folders of the private ones.
"""

from __future__ import annotations

import argparse
import re
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

VENDOR, NAME = "EMA", "ema"
RELEASED = "2026-11-25"
SCHEMA = "http://www.w3.org/2001/XMLSchema-instance"
# Every file of the pack has this time, so that the same sources make the same bytes.
WHEN = (2026, 11, 25, 0, 0, 0)
# What no flag of the user's may change, or the bits are others.
MISC = "-ffp-contract=off -fno-math-errno"


def project(root: Path) -> tuple[str, str]:
    """Version and description, as CMakeLists.txt has them."""
    text = (root / "CMakeLists.txt").read_text(encoding="utf-8")
    found = re.search(r'project\(EMA VERSION ([\d.]+) LANGUAGES C\s+DESCRIPTION "([^"]+)"\)', text)
    if found is None:
        raise SystemExit("make_pack.py: CMakeLists.txt: no line project(EMA VERSION ...): run it in the project's own tree")
    return found.group(1), found.group(2)


def description(root: Path, version: str, what: str) -> bytes:
    """The pack's description."""
    package = ElementTree.Element("package", {"schemaVersion": "1.7.7", f"{{{SCHEMA}}}noNamespaceSchemaLocation": "PACK.xsd"})

    def add(parent: ElementTree.Element, tag: str, text: str = "", **attributes: str) -> ElementTree.Element:
        made = ElementTree.SubElement(parent, tag, attributes)
        made.text = text or None
        return made

    add(package, "vendor", VENDOR)
    add(package, "name", NAME)
    add(package, "description", what)
    add(package, "url", "")
    add(package, "license", "LICENSE")
    add(add(package, "releases"), "release", "First release as a pack.", version=version, date=RELEASED)
    keywords = add(package, "keywords")
    for word in ("prognostics", "actuator", "identification"):
        add(keywords, "keyword", word)
    component = add(add(package, "components"), "component", Cclass="Prognostics", Cgroup="Actuator", Cversion=version)
    add(component, "description", f"{what}. Compile with {MISC}.")
    files = add(component, "files")
    add(files, "file", category="include", name="include/")
    add(files, "file", category="include", name="src/", scope="private")
    for source in sorted((root / "src").glob("*/*.c")):
        add(files, "file", category="sourceC", name=source.relative_to(root).as_posix())
    ElementTree.indent(package)
    return bytes(ElementTree.tostring(package, encoding="utf-8", xml_declaration=True)) + b"\n"


def make(root: Path, folder: Path) -> Path:
    """Write the pack into the folder; its path."""
    version, what = project(root)
    place = folder / f"{VENDOR}.{NAME}.{version}.pack"
    folder.mkdir(parents=True, exist_ok=True)
    held = {f"{VENDOR}.{NAME}.pdsc": description(root, version, what)}
    for path in sorted([root / "LICENSE", *(root / "include").rglob("*"), *(root / "src").rglob("*")]):
        if path.is_file():
            held[path.relative_to(root).as_posix()] = path.read_bytes()
    with zipfile.ZipFile(place, "w", zipfile.ZIP_DEFLATED) as pack:
        for name, data in held.items():
            pack.writestr(zipfile.ZipInfo(name, WHEN), data, zipfile.ZIP_DEFLATED)
    return place


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, required=True)
    print(f"{make(Path(__file__).resolve().parents[2], parser.parse_args().output)} written")
    return 0


if __name__ == "__main__":
    sys.exit(main())
