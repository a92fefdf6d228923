# The module for the browser: lib/ema.wasm, which the page's workbench runs. The same sources in float32, by clang and its wasm-ld, without any C library.
# Without them it is not built, and the configuration and the page say what to install; everything else works.

option(EMA_WASM "Compile the module to WebAssembly for the page's workbench, where clang and wasm-ld are found" ON)

set(ema_wasm_compiler "")
if(EMA_WASM)
    # The newest clang that can link: Debian's clang finds the wasm-ld of its own version.
    set(ema_wasm_tried clang)
    foreach(version RANGE 14 22)
        list(PREPEND ema_wasm_tried "clang-${version}")
    endforeach()
    set(ema_wasm_probe "${CMAKE_BINARY_DIR}/wasm/probe")
    file(WRITE "${ema_wasm_probe}.c" "int probe(int x) { return x + 1; }\n")
    if(CMAKE_C_COMPILER_ID STREQUAL "Clang")
        list(PREPEND ema_wasm_tried "${CMAKE_C_COMPILER}")
    endif()
    foreach(name IN LISTS ema_wasm_tried)
        if(ema_wasm_compiler)
            break()
        endif()
        find_program(EMA_WASM_CLANG_${name} "${name}")
        mark_as_advanced(EMA_WASM_CLANG_${name})
        if(EMA_WASM_CLANG_${name})
            execute_process(COMMAND "${EMA_WASM_CLANG_${name}}" --target=wasm32 -mbulk-memory -nostdlib -Wl,--no-entry -Wl,--export=probe
                                    "${ema_wasm_probe}.c" -o "${ema_wasm_probe}.wasm"
                            RESULT_VARIABLE ema_wasm_failed OUTPUT_QUIET ERROR_QUIET)
            if(ema_wasm_failed EQUAL 0)
                set(ema_wasm_compiler "${EMA_WASM_CLANG_${name}}")
            endif()
        endif()
    endforeach()
    if(NOT ema_wasm_compiler)
        message(STATUS "ema.wasm is not built, so pages have no workbench: install clang and lld (apt-get install clang lld), then build again")
    endif()
endif()

if(ema_wasm_compiler)
    set(ema_wasm_folder "${CMAKE_CURRENT_SOURCE_DIR}/port/wasm")
    set(ema_wasm_desk "")
    # what JavaScript calls: it reads recordings and fits by itself
    foreach(file ema_desk ema_desk_actuator)
        list(APPEND ema_wasm_desk "${CMAKE_CURRENT_SOURCE_DIR}/port/desk/${file}.c")
    endforeach()
    # The module in one piece, so that the compiler sees through the calls of a model step.
    set(ema_wasm_module "${CMAKE_BINARY_DIR}/wasm/ema_module.c")
    set(ema_wasm_lines "")
    foreach(source IN LISTS EMA_SOURCES)
        string(APPEND ema_wasm_lines "#include \"${source}\"\n")
    endforeach()
    file(CONFIGURE OUTPUT "${ema_wasm_module}" CONTENT "${ema_wasm_lines}" @ONLY)
    set(ema_wasm_include "-I${CMAKE_CURRENT_SOURCE_DIR}/include" "-I${EMA_SOURCE_DIR}" "-I${CMAKE_CURRENT_SOURCE_DIR}/port/desk")
    set(ema_wasm_own "")
    if(EMA_OWN_FOLDER)
        set(ema_wasm_own "-DEMA_OWN_EFFECTS=\"${EMA_OWN_FOLDER}/own_effects.def\"")
    endif()
    set(ema_wasm_exports "")
    foreach(name ema_desk_value_count ema_desk_option_count ema_desk_status_text ema_desk_check ema_desk_simulate __heap_base)
        list(APPEND ema_wasm_exports "-Wl,--export=${name}")
    endforeach()
    file(GLOB_RECURSE ema_wasm_headers CONFIGURE_DEPENDS include/*.h include/ema/*.def src/*.h port/desk/*.h port/wasm/include/*.h)
    set(ema_wasm_output "${CMAKE_BINARY_DIR}/lib/ema.wasm")
    add_custom_command(
        OUTPUT "${ema_wasm_output}"
        COMMAND "${CMAKE_COMMAND}" -E make_directory "${CMAKE_BINARY_DIR}/lib"
        # No file of the C library but the three headers beside the port; a stack that, when it overflows, traps and does not write over data.
        COMMAND "${ema_wasm_compiler}" --target=wasm32 -O3 -std=c11 -ffp-contract=off -fno-math-errno -mbulk-memory -fvisibility=hidden
                -Wall -Wextra -Wconversion -nostdlib -isystem "${ema_wasm_folder}/include" ${ema_wasm_include} ${ema_wasm_own}
                -Wl,--no-entry -Wl,--strip-all -Wl,--stack-first -Wl,-z,stack-size=262144 ${ema_wasm_exports}
                "${ema_wasm_module}" ${EMA_OWN_SOURCES} ${ema_wasm_desk} "${ema_wasm_folder}/ema_wasm.c" -o "${ema_wasm_output}"
        DEPENDS ${EMA_SOURCES} ${EMA_OWN_SOURCES} ${ema_wasm_desk} ${ema_wasm_headers} "${ema_wasm_folder}/ema_wasm.c" "${ema_wasm_module}"
        COMMENT "Compiling the module to WebAssembly" VERBATIM)
    add_custom_target(ema_wasm ALL DEPENDS "${ema_wasm_output}")
endif()
