# Toolchain file: the first clang on the machine, under its plain or its versioned name.

find_program(EMA_CLANG NAMES clang clang-19 clang-18 clang-17 clang-16 clang-15 clang-14)
if(NOT EMA_CLANG)
    message(FATAL_ERROR "No clang found: install the package clang, or leave this preset out.")
endif()
set(CMAKE_C_COMPILER "${EMA_CLANG}")
