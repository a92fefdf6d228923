# The module as a component of ESP-IDF, which includes the project's CMakeLists.txt and wants nothing but its registration.

include("${CMAKE_CURRENT_LIST_DIR}/EmaSources.cmake")
idf_component_register(SRCS ${EMA_SOURCES} INCLUDE_DIRS include PRIV_INCLUDE_DIRS "${EMA_SOURCE_DIR}")
target_compile_options(${COMPONENT_LIB} PRIVATE ${EMA_EXACT_FLAGS})
