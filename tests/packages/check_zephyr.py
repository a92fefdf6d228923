"""The module as a module of Zephyr: its description by the keys that Zephyr documents, and a build from a copy by what its CMake lines add; Zephyr itself was not there."""

from __future__ import annotations

import argparse
import shutil
import sys
from pathlib import Path

import yaml
from outside import bits_of_sources, expect, main, run

HERE = Path(__file__).resolve().parent
# Keys of a module's description, and of its section `build` (Zephyr, "Modules (External projects)").
KEYS, BUILD = (
    {"name", "build", "samples", "tests", "boards", "security"},
    {"cmake", "kconfig", "depends", "settings", "cmake-ext", "kconfig-ext", "files", "sysbuild-cmake"},
)
ZEPHYR = """cmake_minimum_required(VERSION 3.25)
project(zephyr_app C)
set(CMAKE_C_STANDARD 11)
function(zephyr_include_directories)
    include_directories(${ARGN})
endfunction()
function(zephyr_library_named name)
    add_library(${name} STATIC)
    set(ZEPHYR_CURRENT_LIBRARY ${name} PARENT_SCOPE)
endfunction()
function(zephyr_library_sources)
    target_sources(${ZEPHYR_CURRENT_LIBRARY} PRIVATE ${ARGN})
endfunction()
function(zephyr_library_include_directories)
    target_include_directories(${ZEPHYR_CURRENT_LIBRARY} PRIVATE ${ARGN})
endfunction()
function(zephyr_library_compile_options)
    target_compile_options(${ZEPHYR_CURRENT_LIBRARY} PRIVATE ${ARGN})
endfunction()
set(CONFIG_EMA ${ASKED})
add_subdirectory("${MODULE}" module)
if(TARGET ema)
    add_executable(outside main.c)
    target_include_directories(outside PRIVATE "${MODULE}/../include")
    target_link_libraries(outside PRIVATE ema m)
endif()
"""


def check(arguments: argparse.Namespace) -> str:
    """The whole way; says what was run."""
    root, work = arguments.root, arguments.work
    copy = work / "ema"
    for name in ("include", "src", "zephyr", "cmake"):
        shutil.copytree(root / name, copy / name)
    module = yaml.safe_load((copy / "zephyr/module.yml").read_text(encoding="utf-8"))
    expect(set(module) <= KEYS and set(module["build"]) <= BUILD, f"zephyr/module.yml: a key that Zephyr does not know: {module}")
    expect(
        (copy / module["build"]["cmake"] / "CMakeLists.txt").is_file() and (copy / module["build"]["kconfig"]).is_file(),
        "zephyr/module.yml names a file that is not there",
    )
    expect(all((copy / folder).is_dir() for folder in module["samples"]), "zephyr/module.yml names a folder of samples that is not there")
    expect("config EMA\n" in (copy / module["build"]["kconfig"]).read_text(encoding="utf-8"), "Kconfig: no EMA")
    project = work / "project"
    project.mkdir()
    (project / "CMakeLists.txt").write_text(ZEPHYR, encoding="utf-8")
    (project / "main.c").write_bytes((HERE / "project/main.c").read_bytes())
    run(["cmake", "-S", project, "-B", work / "without", f"-DMODULE={copy / 'zephyr'}", "-DASKED=OFF"], work)
    run(["cmake", "-S", project, "-B", work / "build", f"-DMODULE={copy / 'zephyr'}", "-DASKED=ON"], work)
    run(["cmake", "--build", work / "build", "-j2"], work)
    said = run([work / "build/outside"], work)
    expect(said == bits_of_sources(root, work), "from Zephyr's module the bits are others")
    samples = sorted((copy / "zephyr/samples").glob("*/sample.yaml"))
    expect(len(samples) > 0, "no sample")
    compiler = ["cc", "-std=c11", "-Wall", "-Wextra", "-Werror", f"-I{copy / 'include'}"]
    for sample in samples:
        run([*compiler, *sample.parent.glob("src/*.c"), work / "build/module/libema.a", "-lm", "-o", work / "sample"], work)
        wanted = yaml.safe_load(sample.read_text(encoding="utf-8"))["tests"]
        lines = [line for one in wanted.values() for line in one["harness_config"]["regex"]]
        printed = run([work / "sample"], work)
        expect(all(line in printed for line in lines), f"{sample.parent.name} prints {printed}, not {lines}")
    return "described as Zephyr documents it, built from a copy by what its lines add, and the sample run on this machine; Zephyr itself was not there"


if __name__ == "__main__":
    sys.exit(main("zephyr", check))
