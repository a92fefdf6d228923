# Target coverage_report: what the tests that ran reached of the module and its host port, as a table and a page.

if(CMAKE_C_FLAGS_DEBUG MATCHES "--coverage" AND CMAKE_BUILD_TYPE STREQUAL "Debug")
    find_program(EMA_GCOVR gcovr)
    if(NOT EMA_GCOVR)
        message(FATAL_ERROR "No gcovr found: install the package gcovr, or leave this preset out.")
    endif()
    set(ema_coverage_page "${CMAKE_BINARY_DIR}/coverage.html")
    add_custom_target(coverage_report
        COMMAND "${EMA_GCOVR}" --root "${CMAKE_CURRENT_SOURCE_DIR}" --filter "src/" --filter "port/host/" --object-directory "${CMAKE_BINARY_DIR}"
                --exclude-unreachable-branches --txt --html-details "${ema_coverage_page}" --print-summary
        COMMAND "${CMAKE_COMMAND}" -E echo "page: ${ema_coverage_page}"
        WORKING_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}"
        COMMENT "" USES_TERMINAL VERBATIM)
endif()
