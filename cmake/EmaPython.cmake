# The Python tools: their environment in the build folder, the launcher `ema`, and the demo.

set(Python3_FIND_VIRTUALENV STANDARD)
find_package(Python3 3.11 COMPONENTS Interpreter)
if(NOT Python3_Interpreter_FOUND)
    message(FATAL_ERROR "Python 3.11 or later is needed for the ema tool: install python3 and python3-venv,"
                        " name one with -DPython3_EXECUTABLE=, or build the C code alone with -DEMA_PYTHON=OFF.")
endif()
execute_process(COMMAND "${Python3_EXECUTABLE}" -c "import ensurepip, venv" RESULT_VARIABLE ema_no_venv OUTPUT_QUIET ERROR_QUIET)
if(ema_no_venv)
    message(FATAL_ERROR "${Python3_EXECUTABLE} cannot make a virtual environment: install the package python3-venv"
                        " (apt-get install python3-venv), then run the same command again.")
endif()

set(EMA_VENV "${CMAKE_BINARY_DIR}/venv")
set(EMA_VENV_PYTHON "${EMA_VENV}/bin/python")
# The stamps lie in the environment, so that removing it makes it anew.
set(ema_lock_run tools/requirements.txt)
set(ema_lock_fleet tools/requirements-fleet.txt)
set(ema_lock_test tools/requirements-test.txt tools/requirements-fleet.txt benchmarks/requirements.txt)
foreach(kind run fleet test)
    set(locks ${ema_lock_${kind}})
    list(TRANSFORM locks PREPEND "${CMAKE_CURRENT_SOURCE_DIR}/")
    set(options ${locks})
    list(TRANSFORM options PREPEND "--lock=")
    set(after "")
    if(NOT kind STREQUAL "run")
        set(after "${EMA_VENV}/run.stamp")
    endif()
    add_custom_command(
        OUTPUT "${EMA_VENV}/${kind}.stamp"
        COMMAND "${Python3_EXECUTABLE}" "${CMAKE_CURRENT_SOURCE_DIR}/cmake/make_venv.py" --venv "${EMA_VENV}" --kind ${kind}
                ${options} --package "${CMAKE_CURRENT_SOURCE_DIR}/tools" --stamp "${EMA_VENV}/${kind}.stamp"
        DEPENDS ${locks} "${CMAKE_CURRENT_SOURCE_DIR}/cmake/make_venv.py" ${after}
        COMMENT "" USES_TERMINAL VERBATIM)
endforeach()
add_custom_target(venv ALL DEPENDS "${EMA_VENV}/run.stamp")
# What `ema fleet --scheduler` needs; the tests need it too.
add_custom_target(venv_fleet DEPENDS "${EMA_VENV}/fleet.stamp")
add_dependencies(venv_fleet venv)
if(EMA_TESTS)
    add_custom_target(venv_test ALL DEPENDS "${EMA_VENV}/test.stamp")
    add_dependencies(venv_test venv)
endif()

# The charting library of the diagnosis page, beside the libraries; fetched, and never part of the project's files.
set(ema_page "${CMAKE_CURRENT_SOURCE_DIR}/tools/page")
add_custom_command(
    OUTPUT "${CMAKE_BINARY_DIR}/lib/page/page.stamp"
    COMMAND "${EMA_VENV_PYTHON}" "${CMAKE_CURRENT_SOURCE_DIR}/cmake/make_page_library.py" --source "${ema_page}" --build "${CMAKE_BINARY_DIR}"
            --output "${CMAKE_BINARY_DIR}/lib/page" --stamp "${CMAKE_BINARY_DIR}/lib/page/page.stamp" $<$<BOOL:${EMA_TESTS}>:--tests>
    DEPENDS "${ema_page}/package.json" "${ema_page}/package-lock.json" "${CMAKE_CURRENT_SOURCE_DIR}/cmake/make_page_library.py" "${EMA_VENV}/run.stamp"
    COMMENT "" USES_TERMINAL VERBATIM COMMAND_EXPAND_LISTS)
add_custom_target(page_library ALL DEPENDS "${CMAKE_BINARY_DIR}/lib/page/page.stamp")
add_dependencies(page_library venv)

configure_file("${CMAKE_CURRENT_SOURCE_DIR}/cmake/ema.in" "${CMAKE_BINARY_DIR}/ema"
               @ONLY NEWLINE_STYLE UNIX
               FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

# Generated files that the project keeps: reference vectors, sizes of effects, the schema.
add_custom_target(written
    COMMAND "${CMAKE_COMMAND}" -E env "EMA_LIBRARY_DIR=${CMAKE_BINARY_DIR}/lib" "EMA_BIN_DIR=${CMAKE_BINARY_DIR}/bin"
            "${EMA_VENV_PYTHON}" -B -m reference_model.vectors "${CMAKE_CURRENT_SOURCE_DIR}/tests/vectors"
    COMMAND "${CMAKE_COMMAND}" -E env "EMA_LIBRARY_DIR=${CMAKE_BINARY_DIR}/lib"
            "${EMA_VENV_PYTHON}" -B -m benchmarks.effects --header "${CMAKE_CURRENT_SOURCE_DIR}/tests/target/ema_costed.def"
    COMMAND "${CMAKE_COMMAND}" -E env "EMA_LIBRARY_DIR=${CMAKE_BINARY_DIR}/lib"
            "${EMA_VENV_PYTHON}" -B -m ema_tools.library.schema "${CMAKE_CURRENT_SOURCE_DIR}/include/ema/detail/ema_schema.h"
    WORKING_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}"
    DEPENDS venv ema_desk32 ema_desk64 ema_identify
    COMMENT "" USES_TERMINAL VERBATIM)

# What the example firmware compiles in: configurations, tables of signatures and an image, for the reference actuator and for a unit with standing effects.
set(ema_export "${CMAKE_CURRENT_SOURCE_DIR}/examples/firmware/export.py")
file(GLOB_RECURSE ema_export_inputs CONFIGURE_DEPENDS tools/ema_tools/*.py recordings/unit/* actuators/reference.toml)
add_custom_command(
    OUTPUT "${EMA_EXPORTED}/exported.stamp"
    COMMAND "${Python3_EXECUTABLE}" -B "${ema_export}" --ema "${CMAKE_BINARY_DIR}/ema" --output "${EMA_EXPORTED}"
    COMMAND "${CMAKE_COMMAND}" -E touch "${EMA_EXPORTED}/exported.stamp"
    DEPENDS "${ema_export}" ${ema_export_inputs} "${EMA_VENV}/run.stamp" ema_desk32 ema_desk64
    COMMENT "Exporting what the example firmware compiles in" VERBATIM)
set(ema_with_all "")
if(EMA_TESTS)
    set(ema_with_all ALL)
endif()
add_custom_target(exported ${ema_with_all} DEPENDS "${EMA_EXPORTED}/exported.stamp")
add_dependencies(exported venv)

add_custom_target(demo
    COMMAND "${CMAKE_BINARY_DIR}/ema" demo
    WORKING_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}"
    DEPENDS venv page_library ema_desk32 ema_desk64
    COMMENT "" USES_TERMINAL VERBATIM)
# The page's workbench holds the module.
if(TARGET ema_wasm)
    add_dependencies(demo ema_wasm)
endif()
