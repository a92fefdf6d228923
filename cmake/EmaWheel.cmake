# What a wheel holds beside the Python package: the libraries that it calls, the reference actuator and the recordings of its demo. Built by pyproject.toml.

foreach(library ema_desk32 ema_desk64)
    install(TARGETS ${library} COMPONENT wheel LIBRARY DESTINATION ema_tools/lib RUNTIME DESTINATION ema_tools/lib)
endforeach()
# The page's workbench, where its compiler was found.
if(TARGET ema_wasm)
    install(FILES "${CMAKE_BINARY_DIR}/lib/ema.wasm" COMPONENT wheel DESTINATION ema_tools/lib)
endif()
# And its charting library.
find_package(Python3 3.11 COMPONENTS Interpreter REQUIRED)
add_custom_target(wheel_page ALL
    COMMAND "${Python3_EXECUTABLE}" "${CMAKE_CURRENT_SOURCE_DIR}/cmake/make_page_library.py" --source "${CMAKE_CURRENT_SOURCE_DIR}/tools/page"
            --build "${CMAKE_BINARY_DIR}" --output "${CMAKE_BINARY_DIR}/lib/page" --stamp "${CMAKE_BINARY_DIR}/lib/page/page.stamp"
    VERBATIM)
install(DIRECTORY "${CMAKE_BINARY_DIR}/lib/page" COMPONENT wheel DESTINATION ema_tools/lib OPTIONAL)
install(DIRECTORY actuators recordings COMPONENT wheel DESTINATION ema_tools/shipped)
