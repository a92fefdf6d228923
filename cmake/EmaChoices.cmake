# What the build of a firmware fixes, so that nothing of the rest is compiled (src/base/ema_choice.h). A configuration fits every build; one that asks for what is left
# out is refused with a status.

option(EMA_ONLY_PI "Control law: proportional and integral action on position alone" OFF)
option(EMA_ONLY_VOLTAGE "Drive: a share of the bus voltage, applied at once, alone" OFF)
option(EMA_ONLY_EXACT "Encoder: feedback that is neither late nor stepped alone" OFF)
option(EMA_ONLY_INT16 "Records: int16 alone" OFF)
option(EMA_ONLY_RECORDED "Command: recorded with the samples alone" OFF)
option(EMA_ONLY_CHECKED "Ranges of a configuration are checked at the desk alone" OFF)

set(EMA_CHOICE_DEFINITIONS "")
foreach(choice PI VOLTAGE EXACT INT16 RECORDED CHECKED)
    if(EMA_ONLY_${choice})
        if(EMA_HOST OR EMA_TESTS)
            message(FATAL_ERROR "EMA_ONLY_${choice} leaves out what tools and tests need: build firmware with -DEMA_HOST=OFF -DEMA_TESTS=OFF.")
        endif()
        list(APPEND EMA_CHOICE_DEFINITIONS EMA_ONLY_${choice}=1)
    endif()
endforeach()
