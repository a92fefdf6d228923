# What the tests that ran reached. A build by gcc with --coverage: lines and branches (targets coverage_report, coverage_page); one by clang with
# -fcoverage-mcdc: conditions of decisions (target coverage_report). In both, coverage_write writes docs/COVERAGE.md.

if(CMAKE_C_FLAGS_DEBUG MATCHES "--coverage" AND CMAKE_BUILD_TYPE STREQUAL "Debug")
    set(ema_coverage lines)
    set(ema_counts "${CMAKE_BINARY_DIR}/*.gcda")
    find_program(EMA_GCOVR gcovr)
    if(NOT EMA_GCOVR)
        message(FATAL_ERROR "No gcovr found: install the package gcovr, or leave this preset out.")
    endif()
    set(ema_coverage_programs --gcovr "${EMA_GCOVR}")
    set(ema_coverage_html "${CMAKE_BINARY_DIR}/coverage.html")
    add_custom_target(coverage_page
        COMMAND "${EMA_GCOVR}" --root "${CMAKE_CURRENT_SOURCE_DIR}" --filter "src/" --filter "port/host/" --object-directory "${CMAKE_BINARY_DIR}"
                --exclude-unreachable-branches --txt --html-details "${ema_coverage_html}" --print-summary
        COMMAND "${CMAKE_COMMAND}" -E echo "page: ${ema_coverage_html}"
        WORKING_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}"
        COMMENT "" USES_TERMINAL VERBATIM)
elseif(CMAKE_C_FLAGS_DEBUG MATCHES "-fcoverage-mcdc" AND CMAKE_BUILD_TYPE STREQUAL "Debug")
    set(ema_coverage mcdc)
    set(ema_counts "${CMAKE_BINARY_DIR}/*.profraw")
    # The programs that read a clang's counts are of its own version.
    string(REGEX MATCH "^[0-9]+" ema_clang_version "${CMAKE_C_COMPILER_VERSION}")
    find_program(EMA_LLVM_COV NAMES llvm-cov-${ema_clang_version})
    find_program(EMA_LLVM_PROFDATA NAMES llvm-profdata-${ema_clang_version})
    if(NOT EMA_LLVM_COV OR NOT EMA_LLVM_PROFDATA)
        message(FATAL_ERROR "No llvm-cov-${ema_clang_version} found: install the package llvm-${ema_clang_version}, or leave this preset out.")
    endif()
    set(ema_coverage_programs --llvm-cov "${EMA_LLVM_COV}" --llvm-profdata "${EMA_LLVM_PROFDATA}")
endif()

if(ema_coverage)
    find_package(Python3 3.11 REQUIRED COMPONENTS Interpreter)
    set(ema_coverage_command "${Python3_EXECUTABLE}" -B "${CMAKE_CURRENT_SOURCE_DIR}/tests/coverage/page.py" ${ema_coverage}
        --root "${CMAKE_CURRENT_SOURCE_DIR}" --build "${CMAKE_BINARY_DIR}" --compiler "${CMAKE_C_COMPILER}" ${ema_coverage_programs})
    # Counts add up over runs, those of tests that are no longer there too, so every build begins with none.
    add_custom_target(coverage_fresh ALL COMMAND "${CMAKE_COMMAND}" "-DCOUNTS=${ema_counts}" -P "${CMAKE_CURRENT_LIST_DIR}/coverage_fresh.cmake" COMMENT "" VERBATIM)
    add_custom_target(coverage_report COMMAND ${ema_coverage_command} COMMENT "" USES_TERMINAL VERBATIM)
    add_custom_target(coverage_write COMMAND ${ema_coverage_command} --write COMMENT "" USES_TERMINAL VERBATIM)
endif()
