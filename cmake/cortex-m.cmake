# What the toolchain files of the Cortex-M cores share; they set EMA_CORTEX, EMA_CORTEX_FPU and EMA_BOARD before they include it.

set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR arm)
# Nothing links before startup code and linker script are named.
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)

find_program(EMA_ARM_GCC arm-none-eabi-gcc)
if(NOT EMA_ARM_GCC)
    message(FATAL_ERROR "No arm-none-eabi-gcc found: install the packages gcc-arm-none-eabi and libnewlib-arm-none-eabi.")
endif()
set(CMAKE_C_COMPILER "${EMA_ARM_GCC}")

set(CMAKE_C_FLAGS_INIT "-mcpu=${EMA_CORTEX} -mthumb -mfloat-abi=hard -mfpu=${EMA_CORTEX_FPU} -ffunction-sections -fdata-sections -fstack-usage -fcallgraph-info=su")
