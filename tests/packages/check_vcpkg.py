"""The module as a port of vcpkg: its manifest by the keys that vcpkg documents, and its portfile run in CMake, the outside project built with what it installed; vcpkg itself was not there."""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from pathlib import Path

from outside import bits_of_sources, expect, main, run, version_of

HERE = Path(__file__).resolve().parent
KEYS = {"name", "version", "description", "license", "dependencies", "homepage", "supports", "features", "port-version", "$schema"}
# What vcpkg's helpers do for one configuration (vcpkg, "Maintainer functions").
HELPERS = """
function(vcpkg_check_linkage)
endfunction()
function(vcpkg_cmake_configure)
    cmake_parse_arguments(one "" "SOURCE_PATH" "OPTIONS" ${ARGN})
    execute_process(COMMAND "${CMAKE_COMMAND}" -S "${one_SOURCE_PATH}" -B "${WORK}/build" -DCMAKE_BUILD_TYPE=Release "-DCMAKE_INSTALL_PREFIX=${CURRENT_PACKAGES_DIR}"
                            -DCMAKE_INSTALL_LIBDIR=lib ${one_OPTIONS} COMMAND_ERROR_IS_FATAL ANY)
endfunction()
function(vcpkg_cmake_install)
    execute_process(COMMAND "${CMAKE_COMMAND}" --build "${WORK}/build" --target install -j2 COMMAND_ERROR_IS_FATAL ANY)
endfunction()
function(vcpkg_cmake_config_fixup)
    cmake_parse_arguments(one "" "PACKAGE_NAME;CONFIG_PATH" "" ${ARGN})
    if(NOT EXISTS "${CURRENT_PACKAGES_DIR}/${one_CONFIG_PATH}/${one_PACKAGE_NAME}Config.cmake")
        message(FATAL_ERROR "no ${one_PACKAGE_NAME}Config.cmake in ${one_CONFIG_PATH}")
    endif()
endfunction()
function(vcpkg_fixup_pkgconfig)
endfunction()
function(vcpkg_install_copyright)
    cmake_parse_arguments(one "" "" "FILE_LIST" ${ARGN})
    configure_file("${one_FILE_LIST}" "${CURRENT_PACKAGES_DIR}/share/ema/copyright" COPYONLY)
endfunction()
"""


def check(arguments: argparse.Namespace) -> str:
    """The whole way; says what was run."""
    root, work = arguments.root, arguments.work
    copy = work / "ema"
    for name in ("include", "src", "cmake", "port/vcpkg"):
        shutil.copytree(root / name, copy / name)
    for name in ("CMakeLists.txt", "LICENSE"):
        shutil.copy(root / name, copy)
    port = copy / "port/vcpkg/ema"
    manifest = json.loads((port / "vcpkg.json").read_text(encoding="utf-8"))
    expect(set(manifest) <= KEYS, f"vcpkg.json: a key that vcpkg does not know: {sorted(set(manifest) - KEYS)}")
    expect(manifest["version"] == version_of(root), f"vcpkg.json has version {manifest['version']}")
    (work / "run.cmake").write_text(f'{HELPERS}\ninclude("${{CURRENT_PORT_DIR}}/portfile.cmake")\n', encoding="utf-8")
    packages = work / "packages"
    run(["cmake", f"-DWORK={work}", f"-DCURRENT_PORT_DIR={port}", f"-DCURRENT_PACKAGES_DIR={packages}", "-P", work / "run.cmake"], work)
    expect((packages / "share/ema/copyright").is_file(), "the portfile installs no copyright")
    project = shutil.copytree(HERE / "project", work / "project")
    run(["cmake", "-S", project, "-B", work / "found", f"-DCMAKE_PREFIX_PATH={packages}"], work)
    run(["cmake", "--build", work / "found"], work)
    expect(run([work / "found/outside"], work) == bits_of_sources(root, work), "from vcpkg's port the bits are others")
    return "the portfile run in CMake, and the outside project built with what it installed; vcpkg itself was not there"


if __name__ == "__main__":
    sys.exit(main("vcpkg", check))
