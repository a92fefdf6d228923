# The recorded cases, and the worn unit of recordings/unit, as a table, and the program that identifies them; for host and target alike.

get_filename_component(ema_recordings "${CMAKE_CURRENT_LIST_DIR}/../../recordings" ABSOLUTE)
set(ema_cases "${ema_recordings}/case_a.csv" "${ema_recordings}/case_b.csv" "${ema_recordings}/case_c.csv" "${ema_recordings}/unit/worn.csv")
set(ema_tables "${CMAKE_CURRENT_BINARY_DIR}/records/ema_recorded_tables.inc")
file(MAKE_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}/records")
add_custom_command(OUTPUT "${ema_tables}"
                   COMMAND "${Python3_EXECUTABLE}" -B "${CMAKE_CURRENT_LIST_DIR}/make_records.py" "${ema_tables}" ${ema_cases}
                   DEPENDS "${CMAKE_CURRENT_LIST_DIR}/make_records.py" ${ema_cases} VERBATIM)

add_library(ema_recorded STATIC "${CMAKE_CURRENT_LIST_DIR}/ema_recorded.c" "${ema_tables}")
ema_compile(ema_recorded)
target_include_directories(ema_recorded PUBLIC "${CMAKE_CURRENT_LIST_DIR}"
                           PRIVATE "${CMAKE_CURRENT_BINARY_DIR}/records" "${EMA_EXPORTED}")
target_link_libraries(ema_recorded PUBLIC EMA::ema)

add_executable(ema_answer "${CMAKE_CURRENT_LIST_DIR}/ema_answer.c")
ema_compile(ema_answer)
target_link_libraries(ema_answer PRIVATE ema_recorded)
