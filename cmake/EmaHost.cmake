# The host side: the C program that reads recordings, and the shared libraries that the Python tools call.

file(GLOB ema_host_sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/port/host/*.c")
file(GLOB ema_desk_sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/port/desk/*.c")
# The libraries read recordings with the very parser of the program.
file(GLOB ema_csv_sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/port/host/ema_csv*.c")

add_executable(ema_identify ${ema_host_sources})
ema_compile(ema_identify)
target_link_libraries(ema_identify PRIVATE ema)

foreach(bits 32 64)
    add_library(ema_desk${bits} SHARED ${ema_desk_sources} ${ema_csv_sources})
    ema_compile(ema_desk${bits})
    # The tools ask the module's own equations, block by block.
    target_include_directories(ema_desk${bits} PRIVATE port/host ${EMA_SOURCE_DIRS})
endforeach()
target_link_libraries(ema_desk32 PRIVATE ema)
target_link_libraries(ema_desk64 PRIVATE ema64)
