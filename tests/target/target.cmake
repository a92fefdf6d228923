# What the tests of the module need on an emulated board: start of a program, emulator, float32 alone (the boards have no float64 unit).

add_subdirectory("${PROJECT_SOURCE_DIR}/port/cortex_m" port_cortex_m)
set(ema_test_bits 32)
set(ema_test_start EMA::board m)
set(ema_emulate "${Python3_EXECUTABLE}" -B "${CMAKE_CURRENT_LIST_DIR}/emulate.py" --board "${EMA_BOARD}")
# The emulator of every program that becomes a test.
set(CMAKE_CROSSCOMPILING_EMULATOR ${ema_emulate} --unity)
