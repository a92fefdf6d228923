# The example firmware on machines other than its own, worn one; for host and target alike: a healthy one, and the healthy one with a dead time that the
# firmware's model does not know. Then the firmware with the own model of a unit that has standing errors, on recorded chirps of that unit: sound, worn, and
# with such a dead time.

set(ema_ace_healthy ACE_PLANT_CSJ_NM=0.138f ACE_PLANT_BLK_MM=0.033f)
set(ema_ace_hidden ${ema_ace_healthy} ACE_PLANT_DEAD_TIME_V=0.3f)
get_target_property(folder ace SOURCE_DIR)
get_target_property(names ace SOURCES)
set(sources "")
foreach(name IN LISTS names)
    cmake_path(ABSOLUTE_PATH name BASE_DIRECTORY "${folder}")
    list(APPEND sources "${name}")
endforeach()
# As the example is.
function(ema_built_as_ace target)
    ema_compile(${target})
    target_include_directories(${target} PRIVATE $<TARGET_PROPERTY:ace,INCLUDE_DIRECTORIES>)
    target_link_libraries(${target} PRIVATE $<TARGET_PROPERTY:ace,LINK_LIBRARIES>)
endfunction()

foreach(machine healthy hidden)
    add_executable(ace_${machine} ${sources})
    ema_built_as_ace(ace_${machine})
    target_compile_definitions(ace_${machine} PRIVATE ${ema_ace_${machine}})
endforeach()

list(TRANSFORM sources REPLACE "/ace_plant\\.c$" "/ace_recorded.c")
foreach(day sound worn hidden)
    set(record "${CMAKE_CURRENT_BINARY_DIR}/records/unit_${day}")
    file(MAKE_DIRECTORY "${record}")
    add_custom_command(OUTPUT "${record}/ace_record.c"
                       COMMAND "${Python3_EXECUTABLE}" -B "${CMAKE_CURRENT_LIST_DIR}/make_records.py" "${record}/ace_record.c" --header ace_record.h
                               "${ema_recordings}/unit/${day}.csv"
                       DEPENDS "${CMAKE_CURRENT_LIST_DIR}/make_records.py" "${ema_recordings}/unit/${day}.csv" VERBATIM)
    add_executable(ace_unit_${day} ${sources} "${record}/ace_record.c")
    ema_built_as_ace(ace_unit_${day})
    target_compile_definitions(ace_unit_${day} PRIVATE ACE_UNIT=1)
endforeach()

# The worn unit again, its configuration the second unit of a binary image; and that image with one bit turned over.
set(ema_ace_image "${EMA_EXPORTED}/ace_units.bin")
foreach(image sound damaged)
    set(source "${CMAKE_CURRENT_BINARY_DIR}/images/${image}/ace_image.c")
    file(MAKE_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}/images/${image}")
    set(flip "")
    if(image STREQUAL "damaged")
        set(flip --flip 400000)
    endif()
    add_custom_command(OUTPUT "${source}"
                       COMMAND "${Python3_EXECUTABLE}" -B "${CMAKE_CURRENT_LIST_DIR}/make_image.py" "${ema_ace_image}" "${source}" ${flip}
                       DEPENDS "${CMAKE_CURRENT_LIST_DIR}/make_image.py" "${ema_ace_image}" VERBATIM)
    add_executable(ace_image_${image} ${sources} "${CMAKE_CURRENT_BINARY_DIR}/records/unit_worn/ace_record.c" "${source}")
    ema_built_as_ace(ace_image_${image})
    target_compile_definitions(ace_image_${image} PRIVATE "ACE_IMAGE=\"unit\"")
    # one of them writes the record
    add_dependencies(ace_image_${image} ace_unit_worn)
endforeach()
# The units of the image on whatever record a file holds: the sound image's source once more.
list(TRANSFORM sources REPLACE ".*/ace_recorded\\.c$" "${CMAKE_CURRENT_LIST_DIR}/ace_file.c")
foreach(name reference_actuator unit)
    string(REPLACE "_" " " unit "${name}")
    add_executable(ace_file_${name} ${sources} "${CMAKE_CURRENT_BINARY_DIR}/images/sound/ace_image.c")
    ema_built_as_ace(ace_file_${name})
    target_compile_definitions(ace_file_${name} PRIVATE "ACE_IMAGE=\"${unit}\"")
    add_dependencies(ace_file_${name} ace_image_sound)
endforeach()
set(ema_ace_programs ace_file_reference_actuator ace_file_unit ace_image_sound ace_image_damaged ace ace_healthy ace_hidden ace_unit_sound ace_unit_worn ace_unit_hidden)
