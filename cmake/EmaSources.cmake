# The module's C files, the two include folders, and the flags that keep its bits: the one list that every build takes.

# A new effect is a new file; no list needs an edit.
get_filename_component(EMA_ROOT "${CMAKE_CURRENT_LIST_DIR}/.." ABSOLUTE)
set(ema_look_again CONFIGURE_DEPENDS)
if(CMAKE_SCRIPT_MODE_FILE)
    # ESP-IDF reads its components in script mode first, where nothing may depend on a later look at the folder.
    set(ema_look_again "")
endif()
file(GLOB EMA_SOURCES ${ema_look_again} "${EMA_ROOT}/src/*/*.c")
if(NOT EMA_SOURCES)
    message(FATAL_ERROR "No C file under ${EMA_ROOT}/src: the checkout is incomplete, clone again.")
endif()

# Private headers are named from src on, as in "base/ema_math.h"; tests/checks/check_layers.py checks which level may include which.
set(EMA_SOURCE_DIR "${EMA_ROOT}/src")

set(EMA_EXACT_FLAGS -ffp-contract=off -fno-math-errno)
