# How this project's own C is compiled: C11 without extensions, the same bits on every machine, strict warnings.

include(CheckCCompilerFlag)

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES AND PROJECT_IS_TOP_LEVEL)
    set(CMAKE_BUILD_TYPE Release CACHE STRING "Kind of build" FORCE)
endif()
# Without a word of the user's the module is built for speed at a desk and for size where flash is short: on a Cortex-M that takes as few instructions. A toolchain's
# own flags, and an -O of the user's among CMAKE_C_FLAGS or CFLAGS, stay.
if(PROJECT_IS_TOP_LEVEL AND NOT DEFINED EMA_RELEASE_FLAGS_SET)
    string(STRIP "${CMAKE_C_FLAGS_RELEASE}" ema_release_flags)
    string(STRIP "${CMAKE_C_FLAGS_RELEASE_INIT}" ema_release_default)
    if(NOT EMA_RELEASE_FLAGS_GIVEN AND ema_release_flags STREQUAL ema_release_default)
        # CMake's -DNDEBUG is left out: the module has no assertions.
        set(ema_release_flags "-O3")
        if(CMAKE_C_FLAGS MATCHES "(^| )-O")
            set(ema_release_flags "")
        elseif(CMAKE_SYSTEM_NAME STREQUAL "Generic")
            set(ema_release_flags "-Os")
        endif()
        set(CMAKE_C_FLAGS_RELEASE "${ema_release_flags}" CACHE STRING "Flags of a Release build" FORCE)
    endif()
    set(EMA_RELEASE_FLAGS_SET ON CACHE INTERNAL "The Release flags are chosen")
endif()

# Value-changing optimisation breaks bit equality between machines, so it is refused, not overridden.
get_directory_property(ema_directory_options COMPILE_OPTIONS)
string(TOUPPER "${CMAKE_BUILD_TYPE}" ema_build_type)
foreach(flag -ffast-math -Ofast -funsafe-math-optimizations -fassociative-math -freciprocal-math -ffinite-math-only
             -fno-signed-zeros)
    string(FIND " ${CMAKE_C_FLAGS} ${CMAKE_C_FLAGS_${ema_build_type}} ${ema_directory_options} " "${flag}" ema_position)
    if(NOT ema_position EQUAL -1)
        message(FATAL_ERROR "The compiler flag ${flag} changes results between machines: remove it from CFLAGS or CMAKE_C_FLAGS.")
    endif()
endforeach()

set(EMA_WARNINGS
    -Wall -Wextra -Wpedantic
    -Wconversion -Wsign-conversion -Wdouble-promotion -Wfloat-conversion
    -Wvla -Wundef -Wshadow -Wstrict-prototypes -Wmissing-prototypes -Wmissing-declarations -Wold-style-definition
    -Wcast-qual -Wcast-align -Wpointer-arith -Wwrite-strings -Wswitch-enum -Wswitch-default -Wformat=2
    -Wredundant-decls -Wnested-externs -Winit-self -Wnull-dereference)
if(CMAKE_C_COMPILER_ID STREQUAL "GNU")
    list(APPEND EMA_WARNINGS -Wlogical-op -Wduplicated-cond -Wduplicated-branches -Wjump-misses-init)
endif()

# A model step writes its values one by one and reads them again at once. Vectorised, a read of several of them waits until the
# writes have left the processor's store buffer, which costs more than it saves.
set(EMA_CODE_FLAGS "")
foreach(flag ${EMA_EXACT_FLAGS} -fno-tree-vectorize -fno-tree-slp-vectorize)
    string(MAKE_C_IDENTIFIER "EMA_HAS${flag}" ema_has)
    check_c_compiler_flag(${flag} ${ema_has})
    if(${ema_has})
        list(APPEND EMA_CODE_FLAGS ${flag})
    endif()
endforeach()

# ema_compile(target): language, rules of the code and warnings for one target of this project.
function(ema_compile target)
    target_compile_features(${target} PUBLIC c_std_11)
    set_target_properties(${target} PROPERTIES C_STANDARD 11 C_STANDARD_REQUIRED ON C_EXTENSIONS OFF)
    target_compile_options(${target} PRIVATE ${EMA_CODE_FLAGS})
    if(PROJECT_IS_TOP_LEVEL)
        target_compile_options(${target} PRIVATE ${EMA_WARNINGS})
    endif()
    if(EMA_WERROR)
        target_compile_options(${target} PRIVATE -Werror)
    endif()
endfunction()
