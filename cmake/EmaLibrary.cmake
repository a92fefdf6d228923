# The module itself: `ema` in float32, `ema64` from the same sources in float64 (EMA_FLOAT64).

include(CMakePackageConfigHelpers)

# Without an operating system nothing is moved, and a table of addresses would only cost flash.
set(ema_relocatable ON)
if(CMAKE_SYSTEM_NAME STREQUAL "Generic")
    set(ema_relocatable OFF)
endif()

# Without optimisation the square root is a call, with an operating system or without one.
set(ema_math "")
if(CMAKE_C_COMPILER_ID MATCHES "^(GNU|Clang|AppleClang)$" AND NOT MSVC)
    set(ema_math m)
endif()

set(ema_libraries ema)
if(EMA_FLOAT64)
    list(APPEND ema_libraries ema64)
endif()
foreach(target IN LISTS ema_libraries)
    add_library(${target} STATIC ${EMA_SOURCES} ${EMA_OWN_SOURCES})
    add_library(EMA::${target} ALIAS ${target})
    ema_compile(${target})
    target_include_directories(${target}
        PUBLIC "$<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>" "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>"
        PRIVATE "${EMA_SOURCE_DIR}")
    target_compile_definitions(${target} PRIVATE ${EMA_EFFECT_DEFINITIONS} ${EMA_CHOICE_DEFINITIONS} PUBLIC ${EMA_SCHEMA_DEFINITIONS})
    # The desktop libraries contain these objects, and show only their own functions.
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ${ema_relocatable} C_VISIBILITY_PRESET hidden)
    if(EMA_OWN_FOLDER)
        target_compile_definitions(${target} PUBLIC "$<BUILD_INTERFACE:EMA_OWN_EFFECTS=\"${EMA_OWN_FOLDER}/own_effects.def\">"
                                   "$<INSTALL_INTERFACE:EMA_OWN_EFFECTS=\"ema/own_effects.def\">")
    endif()
    target_link_libraries(${target} PUBLIC ${ema_math})
endforeach()
if(EMA_FLOAT64)
    target_compile_definitions(ema64 PUBLIC EMA_REAL64=1)
endif()
if(CMAKE_C_COMPILER_ID STREQUAL "GNU" AND PROJECT_IS_TOP_LEVEL)
    target_compile_options(ema PRIVATE -Wunsuffixed-float-constants)
endif()

install(TARGETS ${ema_libraries} EXPORT EMATargets ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}")
install(DIRECTORY include/ema DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" FILES_MATCHING PATTERN "*.h" PATTERN "*.def")
if(EMA_OWN_FOLDER)
    install(FILES "${EMA_OWN_FOLDER}/own_effects.def" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/ema")
endif()
install(EXPORT EMATargets NAMESPACE EMA:: DESTINATION "${CMAKE_INSTALL_LIBDIR}/cmake/EMA" FILE EMAConfig.cmake)
write_basic_package_version_file("${CMAKE_CURRENT_BINARY_DIR}/EMAConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${CMAKE_CURRENT_BINARY_DIR}/EMAConfigVersion.cmake" DESTINATION "${CMAKE_INSTALL_LIBDIR}/cmake/EMA")

# For builds by pkg-config: paths are found from the file's own place, so that what is installed may be moved.
set(EMA_PC_LIBS "-lema")
set(EMA_PC_CFLAGS "")
foreach(library IN LISTS ema_math)
    string(APPEND EMA_PC_LIBS " -l${library}")
endforeach()
if(EMA_OWN_FOLDER)
    set(EMA_PC_CFLAGS " -DEMA_OWN_EFFECTS='\"ema/own_effects.def\"'")
endif()
file(RELATIVE_PATH EMA_PC_PREFIX "/prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/prefix")
configure_file("${CMAKE_CURRENT_SOURCE_DIR}/cmake/ema.pc.in" "${CMAKE_CURRENT_BINARY_DIR}/ema.pc" @ONLY NEWLINE_STYLE UNIX)
install(FILES "${CMAKE_CURRENT_BINARY_DIR}/ema.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig")
