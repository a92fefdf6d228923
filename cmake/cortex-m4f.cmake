# Toolchain file: Cortex-M4 with its single-precision unit, and the emulated board that the tests run on.

set(EMA_CORTEX cortex-m4)
set(EMA_CORTEX_FPU fpv4-sp-d16)
set(EMA_BOARD mps2-an386)
include("${CMAKE_CURRENT_LIST_DIR}/cortex-m.cmake")
