# Uses the module as another project would: as a folder and installed; and shows that value-changing flags are refused.
# cmake -DSOURCE=project -DBUILD=its build -DWORK=scratch -DCOMPILER=cc -P check_consumer.cmake

function(run)
    execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(NOT result EQUAL 0)
        list(JOIN ARGN " " shown)
        message("${output}")
        message(FATAL_ERROR "consumer: this failed: ${shown}")
    endif()
endfunction()

file(REMOVE_RECURSE "${WORK}")
set(configure "${CMAKE_COMMAND}" -S "${CMAKE_CURRENT_LIST_DIR}/consumer" "-DCMAKE_C_COMPILER=${COMPILER}")

run("${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${WORK}/prefix" --config Release)
run(${configure} -B "${WORK}/installed" "-DCMAKE_PREFIX_PATH=${WORK}/prefix")
run(${configure} -B "${WORK}/folder" "-DEMA_SOURCE=${SOURCE}")
foreach(kind installed folder)
    run("${CMAKE_COMMAND}" --build "${WORK}/${kind}")
    foreach(bits 32 64)
        file(GLOB program "${WORK}/${kind}/consumer${bits}" "${WORK}/${kind}/*/consumer${bits}")
        run("${program}")
    endforeach()
endforeach()

foreach(flag -ffast-math -Ofast -ffinite-math-only)
    execute_process(
        COMMAND "${CMAKE_COMMAND}" -S "${SOURCE}" -B "${WORK}/refused" "-DCMAKE_C_COMPILER=${COMPILER}" "-DCMAKE_C_FLAGS=${flag}"
                -DEMA_TESTS=OFF -DEMA_HOST=OFF
        RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE message)
    if(result EQUAL 0 OR NOT message MATCHES "The compiler flag ${flag}")
        message(FATAL_ERROR "A configuration with ${flag} was not refused: ${message}")
    endif()
endforeach()
execute_process(
    COMMAND "${CMAKE_COMMAND}" -S "${SOURCE}" -B "${WORK}/unknown" "-DCMAKE_C_COMPILER=${COMPILER}" "-DEMA_EFFECTS=jam_spot;jam_spots"
            -DEMA_TESTS=OFF -DEMA_HOST=OFF
    RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE message)
if(result EQUAL 0 OR NOT message MATCHES "EMA_EFFECTS: jam_spots is no effect.*stribeck_friction")
    message(FATAL_ERROR "An effect that the list does not have was not refused: ${message}")
endif()
# What a firmware fixes is an option each, and none of a build with tools or tests.
set(choices PI VOLTAGE EXACT INT16 RECORDED CHECKED)
list(TRANSFORM choices PREPEND "-DEMA_ONLY_" OUTPUT_VARIABLE options)
list(TRANSFORM options APPEND "=ON")
run("${CMAKE_COMMAND}" -S "${SOURCE}" -B "${WORK}/fixed" "-DCMAKE_C_COMPILER=${COMPILER}" ${options} -DEMA_TESTS=OFF -DEMA_HOST=OFF -DEMA_FLOAT64=OFF)
file(READ "${WORK}/fixed/compile_commands.json" commands)
foreach(choice IN LISTS choices)
    if(NOT commands MATCHES "-DEMA_ONLY_${choice}=1 ")
        message(FATAL_ERROR "EMA_ONLY_${choice} does not reach the compiler")
    endif()
    execute_process(
        COMMAND "${CMAKE_COMMAND}" -S "${SOURCE}" -B "${WORK}/fixed_tests" "-DCMAKE_C_COMPILER=${COMPILER}" -DEMA_ONLY_${choice}=ON -DEMA_TESTS=ON -DEMA_HOST=OFF
        RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE message)
    file(REMOVE_RECURSE "${WORK}/fixed_tests")
    if(result EQUAL 0 OR NOT message MATCHES "EMA_ONLY_${choice} leaves out what tools and tests need")
        message(FATAL_ERROR "EMA_ONLY_${choice} was not refused beside tests: ${message}")
    endif()
endforeach()
message(STATUS "consumer: installed and as a folder, float32 and float64; value-changing flags and unknown effects refused, what is fixed reaches the compiler")
