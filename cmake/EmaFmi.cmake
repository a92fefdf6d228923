# The co-simulation units of FMI 3.0: ema_actuator.fmu, plant and controller, and ema_plant.fmu. Their headers are the standard's own, which FMPy ships.

find_path(EMA_FMI_HEADERS fmi3Functions.h DOC "Folder with the FMI standard's fmi3Functions.h; FMPy has it in fmpy/c-code")
if(NOT EMA_FMI_HEADERS)
    message(FATAL_ERROR "No fmi3Functions.h found: name its folder with -DEMA_FMI_HEADERS=, for example fmpy/c-code of the Python package FMPy.")
endif()
if(NOT EMA_FLOAT64)
    message(FATAL_ERROR "The co-simulation units compute in float64: leave EMA_FLOAT64 on.")
endif()

string(TOLOWER "${CMAKE_SYSTEM_PROCESSOR}-${CMAKE_SYSTEM_NAME}" ema_fmi_platform)
string(REPLACE "amd64" "x86_64" ema_fmi_platform "${ema_fmi_platform}")
string(REPLACE "arm64" "aarch64" ema_fmi_platform "${ema_fmi_platform}")

# A description fits the library that was built from the same lists.
set(ema_fmi_lists "")
foreach(list include/ema/ema_params.def include/ema/ema_effects.def port/fmi/ema_fmi_list.h)
    list(APPEND ema_fmi_lists "${CMAKE_CURRENT_SOURCE_DIR}/${list}")
endforeach()
set(ema_fmi_text "${PROJECT_VERSION}")
if(EMA_OWN_FOLDER)
    list(APPEND ema_fmi_lists "${EMA_OWN_FOLDER}/own_effects.def")
endif()
foreach(list IN LISTS ema_fmi_lists)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${list}")
    file(SHA256 "${list}" ema_fmi_hash)
    string(APPEND ema_fmi_text "${ema_fmi_hash}")
endforeach()
string(SHA256 ema_fmi_token "${ema_fmi_text}")

set_source_files_properties(port/fmi/ema_fmi_absent.c PROPERTIES COMPILE_OPTIONS -Wno-unused-parameter)
foreach(name ema_actuator ema_plant)
    add_executable(${name}_describe port/fmi/ema_fmi_describe.c)
    add_library(${name}_fmi MODULE port/fmi/ema_fmi.c port/fmi/ema_fmi_absent.c)
    foreach(target ${name}_describe ${name}_fmi)
        ema_compile(${target})
        target_compile_definitions(${target} PRIVATE EMA_FMI_PLANT=$<STREQUAL:${name},ema_plant> EMA_FMI_TOKEN="${ema_fmi_token}")
        target_link_libraries(${target} PRIVATE ema64)
    endforeach()
    target_include_directories(${name}_fmi SYSTEM PRIVATE "${EMA_FMI_HEADERS}")
    set(folder "${CMAKE_BINARY_DIR}/fmi/${name}")
    set_target_properties(${name}_fmi PROPERTIES PREFIX "" OUTPUT_NAME ${name} LIBRARY_OUTPUT_DIRECTORY "$<1:${folder}/binaries/${ema_fmi_platform}>")
    add_custom_command(
        OUTPUT "${CMAKE_BINARY_DIR}/fmi/${name}.fmu"
        COMMAND ${name}_describe ${name} ${PROJECT_VERSION} ${ema_fmi_token} > "${folder}/modelDescription.xml"
        COMMAND "${CMAKE_COMMAND}" -E chdir "${folder}" "${CMAKE_COMMAND}" -E tar cf "${CMAKE_BINARY_DIR}/fmi/${name}.fmu" --format=zip modelDescription.xml binaries
        DEPENDS ${name}_describe ${name}_fmi COMMENT "" VERBATIM)
    add_custom_target(${name}_fmu ALL DEPENDS "${CMAKE_BINARY_DIR}/fmi/${name}.fmu")
endforeach()
