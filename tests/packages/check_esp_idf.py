"""The module as a component of ESP-IDF: packed by Espressif's tool, which checks its manifest, and built from the pack by what the component registers."""

from __future__ import annotations

import argparse
import shutil
import sys
import tarfile
from pathlib import Path

from outside import bits_of_sources, expect, main, run, version_of

HERE = Path(__file__).resolve().parent
# What ESP-IDF has of its own and the component calls; the component's own lines are the pack's.
IDF = """cmake_minimum_required(VERSION 3.25)
project(idf_app C)
function(idf_component_register)
    cmake_parse_arguments(one "" "" "SRCS;INCLUDE_DIRS;PRIV_INCLUDE_DIRS" ${ARGN})
    add_library(idf_ema STATIC ${one_SRCS})
    foreach(folder IN LISTS one_INCLUDE_DIRS)
        target_include_directories(idf_ema PUBLIC "${CMAKE_CURRENT_SOURCE_DIR}/${folder}")
    endforeach()
    target_include_directories(idf_ema PRIVATE ${one_PRIV_INCLUDE_DIRS})
    set(COMPONENT_LIB idf_ema PARENT_SCOPE)
endfunction()
set(ESP_PLATFORM 1)
set(CMAKE_C_STANDARD 11)
add_subdirectory("${COMPONENT}" ema)
add_executable(outside main.c)
target_link_libraries(outside PRIVATE idf_ema m)
"""


def check(arguments: argparse.Namespace) -> str:
    """The whole way; says what was run."""
    root, work = arguments.root, arguments.work
    version = version_of(root)
    compote = Path(sys.executable).with_name("compote")
    copy = work / "copy"
    for name in ("include", "src", "cmake", "zephyr", "actuators"):
        shutil.copytree(root / name, copy / name)
    for name in ("CMakeLists.txt", "idf_component.yml", "LICENSE", "README.md"):
        shutil.copy(root / name, copy)
    (copy / "docs").mkdir()
    (copy / "docs/left_out.md").write_text("no part of the component\n", encoding="utf-8")
    run([compote, "component", "pack", "--name", "ema", "--dest-dir", work / "dist", "--project-dir", copy], work, {"HOME": str(work)})
    packs = sorted((work / "dist").glob("ema_*.tgz"))
    expect([pack.name for pack in packs] == [f"ema_{version}.tgz"], f"packed: {[pack.name for pack in packs]}, not version {version}")
    with tarfile.open(packs[0]) as pack:
        pack.extractall(work / "ema", filter="data")
    kept = {path.name for path in (work / "ema").iterdir()}
    expect(not kept & {"recordings", "tools", "docs"}, f"the pack holds more than the component: {sorted(kept)}")
    project = work / "project"
    project.mkdir()
    (project / "CMakeLists.txt").write_text(IDF, encoding="utf-8")
    (project / "main.c").write_bytes((HERE / "project/main.c").read_bytes())
    run(["cmake", "-S", project, "-B", work / "build", f"-DCOMPONENT={work / 'ema'}"], work)
    run(["cmake", "--build", work / "build", "-j2"], work)
    said = run([work / "build/outside"], work)
    expect(said == bits_of_sources(root, work), "from ESP-IDF's component the bits are others")
    return "packed by Espressif's component manager, and built from the pack by what it registers; ESP-IDF itself was not there"


if __name__ == "__main__":
    sys.exit(main("esp_idf", check))
