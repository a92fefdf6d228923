# Toolchain file: Cortex-M33 with its single-precision unit, and the emulated board that the tests run on.

set(EMA_CORTEX cortex-m33)
set(EMA_CORTEX_FPU fpv5-sp-d16)
set(EMA_BOARD mps2-an505)
include("${CMAKE_CURRENT_LIST_DIR}/cortex-m.cmake")
