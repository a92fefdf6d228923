# The host side: the C program that reads recordings, and the shared libraries that the Python tools call.

file(GLOB ema_host_sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/port/host/*.c")
file(GLOB ema_desk_sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/port/desk/*.c")
# The libraries read recordings with the very parser of the program.
file(GLOB ema_csv_sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/port/host/ema_csv*.c")

add_executable(ema_identify ${ema_host_sources})
ema_compile(ema_identify)
target_link_libraries(ema_identify PRIVATE ema)

foreach(bits 32 64)
    string(REPLACE "32" "" module "ema${bits}")
    add_library(ema_desk${bits} SHARED ${ema_desk_sources} ${ema_csv_sources})
    ema_compile(ema_desk${bits})
    # The tools ask the module's own equations, block by block.
    target_include_directories(ema_desk${bits} PRIVATE port/host ${EMA_SOURCE_DIRS})
    target_link_libraries(ema_desk${bits} PRIVATE ${module})

    # A desk simulates a thousand runs for one answer: in one piece, so that the compiler sees through the calls of a model step. Files of one's own stay apart, as their names are.
    if(CMAKE_BUILD_TYPE STREQUAL "Release")
        add_library(ema_desk_module${bits} OBJECT ${EMA_SOURCES} ${EMA_OWN_SOURCES})
        ema_compile(ema_desk_module${bits})
        target_include_directories(ema_desk_module${bits} PRIVATE ${EMA_SOURCE_DIRS})
        target_compile_definitions(ema_desk_module${bits} PRIVATE ${EMA_EFFECT_DEFINITIONS})
        target_link_libraries(ema_desk_module${bits} PRIVATE ${module})
        set_target_properties(ema_desk_module${bits} PROPERTIES
            POSITION_INDEPENDENT_CODE ON C_VISIBILITY_PRESET hidden UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
        target_sources(ema_desk${bits} PRIVATE $<TARGET_OBJECTS:ema_desk_module${bits}>)
    endif()
endforeach()

# Many actuators side by side, in libraries of their own: here the compiler is to use vectors, of whatever width it is told. Wider ones than every processor
# has are a second library; the tools take it where they can. The bits are the same: no flag here changes what is computed, only when.
file(GLOB ema_lanes_sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/port/lanes/*.c")
set(ema_lanes_flags "")
# a compiler that knows a flag and does nothing with it says so by a warning
set(CMAKE_REQUIRED_FLAGS -Werror)
# Loops over lanes have no branch as they are written. The compiler leaves them so where it may not move work behind a question, nor guess at its answer;
# copies stay vectors, which a call in other widths would make the next read wait for; and what an effect works out is seen from the loop.
foreach(flag -fno-semantic-interposition -ftree-loop-vectorize -fno-trapping-math -fno-tree-loop-distribute-patterns -fno-unswitch-loops -fno-tree-sink -fno-thread-jumps
             --param=max-inline-insns-auto=400 --param=max-inline-insns-single=2000 --param=inline-unit-growth=400 --param=large-function-growth=1000)
    string(MAKE_C_IDENTIFIER "EMA_HAS${flag}" ema_has)
    check_c_compiler_flag(${flag} ${ema_has})
    if(${ema_has})
        list(APPEND ema_lanes_flags ${flag})
    endif()
endforeach()
unset(CMAKE_REQUIRED_FLAGS)
# A loop that clang leaves as it is has the same bits and is slower: no error.
if(CMAKE_C_COMPILER_ID MATCHES "Clang")
    list(APPEND ema_lanes_flags -Wno-pass-failed)
endif()
set(ema_lanes_module ${EMA_SOURCES})
list(FILTER ema_lanes_module INCLUDE REGEX "/src/(base|effects|blocks|plant)/")
set(ema_lanes_widths "")
set(EMA_LANES_LIBRARIES "")
check_c_compiler_flag(-mavx2 EMA_HAS_mavx2)
if(EMA_HAS_mavx2)
    set(ema_lanes_widths _avx2)
endif()
# The desk asks for a few runs in float32 at a time, most often: half the lanes for them.
foreach(kind 32 32_few 64)
    string(SUBSTRING ${kind} 0 2 bits)
    string(REPLACE "32" "" module "ema${bits}")
    foreach(width "" ${ema_lanes_widths})
        set(library "ema_lanes${kind}${width}")
        list(APPEND EMA_LANES_LIBRARIES ${library})
        add_library(${library} SHARED ${ema_lanes_sources} "${CMAKE_CURRENT_SOURCE_DIR}/port/desk/ema_desk_actuator.c")
        ema_compile(${library})
        target_include_directories(${library} PRIVATE port/desk ${EMA_SOURCE_DIRS})
        target_compile_options(${library} PRIVATE ${ema_lanes_flags})
        if(kind MATCHES "few")
            target_compile_definitions(${library} PRIVATE EMA_LANES=8U)
        endif()
        if(width)
            target_compile_options(${library} PRIVATE -mavx2)
        endif()
        target_link_libraries(${library} PRIVATE ${module})
        # Nobody asks for them where neither the tools are set up nor the compiler works on several numbers at once.
        if(NOT EMA_PYTHON AND CMAKE_BUILD_TYPE STREQUAL "Debug")
            set_target_properties(${library} PROPERTIES EXCLUDE_FROM_ALL ON)
        endif()
        # In one piece, or an effect would be a call for each lane.
        if(CMAKE_BUILD_TYPE STREQUAL "Release")
            target_sources(${library} PRIVATE ${ema_lanes_module} ${EMA_OWN_SOURCES})
            target_compile_definitions(${library} PRIVATE ${EMA_EFFECT_DEFINITIONS})
            set_target_properties(${library} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
        endif()
    endforeach()
endforeach()
if(EMA_OWN_SOURCES)
    set_source_files_properties(${EMA_OWN_SOURCES} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endif()
