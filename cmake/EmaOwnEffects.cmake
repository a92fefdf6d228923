# Effects of one's own, outside the project's files: a folder with own_effects.def and the C files of its rows. docs/YOUR_OWN_EFFECT.md tells how.

set(EMA_OWN_EFFECTS "" CACHE PATH "Folder with effects of your own; own_effects in the project's folder when empty")

set(EMA_OWN_FOLDER "")
if(EMA_OWN_EFFECTS)
    get_filename_component(EMA_OWN_FOLDER "${EMA_OWN_EFFECTS}" ABSOLUTE BASE_DIR "${CMAKE_SOURCE_DIR}")
    if(NOT EXISTS "${EMA_OWN_FOLDER}/own_effects.def")
        message(FATAL_ERROR "EMA_OWN_EFFECTS=${EMA_OWN_EFFECTS} holds no own_effects.def: write its rows there, see docs/YOUR_OWN_EFFECT.md.")
    endif()
elseif(PROJECT_IS_TOP_LEVEL AND EXISTS "${CMAKE_CURRENT_SOURCE_DIR}/own_effects/own_effects.def")
    set(EMA_OWN_FOLDER "${CMAKE_CURRENT_SOURCE_DIR}/own_effects")
endif()
if(EMA_OWN_FOLDER AND EMA_TESTS)
    message(STATUS "Own effects: left out, the tests are those of the project's own library")
    set(EMA_OWN_FOLDER "")
endif()

set(EMA_OWN_SOURCES "")
if(EMA_OWN_FOLDER)
    file(GLOB EMA_OWN_SOURCES CONFIGURE_DEPENDS "${EMA_OWN_FOLDER}/*.c")
    message(STATUS "Own effects: ${EMA_OWN_FOLDER}")
endif()
