# The number of the lists that make an actuator, as ema_schema.h says it of the project's own: where these lists are others, it is defined for the module and
# for all that use it. The compiler reads the lists, here as everywhere.

set(ema_own "")
if(EMA_OWN_FOLDER)
    set(ema_own "-DEMA_OWN_EFFECTS=\"${EMA_OWN_FOLDER}/own_effects.def\"")
endif()
set(ema_rows "${CMAKE_CURRENT_BINARY_DIR}/ema_schema_rows.c")
file(WRITE "${ema_rows}" "\
#define EMA_PARAM(section, field, nominal, lower, upper, text) ema_row_real(section.field)
#define EMA_OPTION(section, field, nominal, lower, upper, choices, text) ema_row_whole(section.field)
#include \"ema/ema_params.def\"
#define EMA_P(field, nominal, lower, upper, text) ema_row_value(field)
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters) ema_row_effect(name) parameters
#include \"ema/ema_effects.def\"
")
execute_process(COMMAND "${CMAKE_C_COMPILER}" -E ${ema_own} -I "${CMAKE_CURRENT_SOURCE_DIR}/include" "${ema_rows}"
                OUTPUT_VARIABLE ema_read ERROR_VARIABLE ema_why RESULT_VARIABLE ema_failed)
if(ema_failed)
    message(FATAL_ERROR "The lists of parameters and effects cannot be read: correct the row.\n${ema_why}")
endif()
string(REGEX MATCHALL "ema_row_[a-z]+ *\\([^()]*\\)" ema_read "${ema_read}")
list(TRANSFORM ema_read REPLACE "ema_row_| " "")
list(JOIN ema_read "\n" ema_read)
string(SHA256 ema_schema "${ema_read}")
string(SUBSTRING "${ema_schema}" 0 8 ema_schema)

set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS include/ema/ema_params.def include/ema/ema_effects.def include/ema/detail/ema_schema.h)
file(STRINGS "${CMAKE_CURRENT_SOURCE_DIR}/include/ema/detail/ema_schema.h" ema_written REGEX "define EMA_CONFIG_SCHEMA 0x${ema_schema}U")
set(EMA_SCHEMA_DEFINITIONS "")
if(NOT ema_written)
    set(EMA_SCHEMA_DEFINITIONS "EMA_CONFIG_SCHEMA=0x${ema_schema}U")
    message(STATUS "The lists are not those of ema_schema.h: ${EMA_SCHEMA_DEFINITIONS}")
endif()
