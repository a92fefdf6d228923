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
    target_include_directories(ema_desk${bits} PRIVATE port/host "${EMA_SOURCE_DIR}")

    # A desk simulates a thousand runs for one answer: in one piece, so that the compiler sees through the calls of a model step. Files of one's own stay apart, as their names are.
    # It takes the include folders and definitions of the module's library, but does not wait for it.
    if(NOT CMAKE_BUILD_TYPE STREQUAL "Release")
        target_link_libraries(ema_desk${bits} PRIVATE ${module})
    else()
        add_library(ema_desk_module${bits} OBJECT ${EMA_SOURCES} ${EMA_OWN_SOURCES})
        ema_compile(ema_desk_module${bits})
        target_include_directories(ema_desk_module${bits} PRIVATE "${EMA_SOURCE_DIR}")
        target_compile_definitions(ema_desk_module${bits} PRIVATE ${EMA_EFFECT_DEFINITIONS})
        foreach(target ema_desk${bits} ema_desk_module${bits})
            target_include_directories(${target} PRIVATE $<TARGET_PROPERTY:${module},INTERFACE_INCLUDE_DIRECTORIES>)
            target_compile_definitions(${target} PRIVATE $<TARGET_PROPERTY:${module},INTERFACE_COMPILE_DEFINITIONS>)
        endforeach()
        target_link_libraries(ema_desk${bits} PRIVATE ${ema_math})
        set_target_properties(ema_desk_module${bits} PROPERTIES
            POSITION_INDEPENDENT_CODE ON C_VISIBILITY_PRESET hidden UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
        target_sources(ema_desk${bits} PRIVATE $<TARGET_OBJECTS:ema_desk_module${bits}>)
    endif()
endforeach()

if(EMA_OWN_SOURCES)
    set_source_files_properties(${EMA_OWN_SOURCES} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endif()
