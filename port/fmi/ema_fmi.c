/* The model as a co-simulation unit: Functional Mock-up Interface Specification 3.0.2, Modelica Association 2024,
 * sections 2.2, 2.3 and 4. A communication step is a whole number of model steps, with the input held; outputs are
 * those at the communication point, the voltage by the input that is set there. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ema/ema.h"
#include "ema_fmi_list.h"
#include <fmi3Functions.h>

/* A controller that passes its command on: full output is asked by a position so far away that the actuator's own is
 * not seen beside it; less than 1e-9 of the full output. */
#define EMA_FMI_PASS_KP_PER_M EMA_R(1.0e-8)
#define EMA_FMI_PASS_MM EMA_R(1.0e11)

/* By how much of a model step a communication step may miss a whole number of them. */
#define EMA_FMI_SLACK 1.0e-6

typedef struct {
    ema_actuator_t actuator;
    ema_model_t model;
    ema_output_t shown;
    double input;
    double start_mm;
    double begin_s; /* time at which the model started */
    uint64_t steps;
    bool prepared;
    bool fresh; /* `shown` is that of state and input as they are */
} ema_fmi_state_t;

typedef struct {
    ema_fmi_state_t state;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} ema_fmi_t;

static fmi3Status ema_fmi_fail(const ema_fmi_t* unit, const char* format, ...)
{
    char message[256];
    va_list words;
    va_start(words, format);
    (void)vsnprintf(message, sizeof message, format, words);
    va_end(words);
    if ((unit != NULL) && (unit->log != NULL)) {
        unit->log(unit->environment, fmi3Error, "logStatusError", message);
    }
    return fmi3Error;
}

static void ema_fmi_begin(ema_fmi_state_t* state)
{
    const ema_fmi_state_t none = {0};
    *state = none;
    (void)ema_actuator_defaults(&state->actuator);
#if EMA_FMI_PLANT
    state->actuator.params.kp_per_m = EMA_FMI_PASS_KP_PER_M;
    state->actuator.params.ki_per_m_s = EMA_R(0.0);
    state->actuator.params.kd_s_per_m = EMA_R(0.0);
    state->actuator.params.output_limit = EMA_R(1.0);
#endif
}

static ema_real ema_fmi_command(const ema_fmi_state_t* state)
{
    return EMA_FMI_PLANT ? ((ema_real)state->input * EMA_FMI_PASS_MM) : (ema_real)state->input;
}

/* What the model shows at this instant is what its next step would begin with. */
static fmi3Status ema_fmi_look(ema_fmi_t* unit)
{
    ema_fmi_state_t* const state = &unit->state;
    if (!state->fresh) {
        static const ema_output_t nothing = {0};
        state->shown = nothing;
        if (state->prepared) {
            ema_model_t ahead = state->model;
            const ema_status_t status = ema_model_step(&ahead, ema_fmi_command(state), &state->shown);
            if (status != EMA_OK) {
                return ema_fmi_fail(unit, "input %g: %s", state->input, ema_status_text(status));
            }
        }
        state->fresh = true;
    }
    return fmi3OK;
}

static double ema_fmi_shown(const ema_output_t* shown, fmi3ValueReference reference)
{
    switch ((int)reference - (int)EMA_FMI_POSITION) {
    case 0:
        return (double)shown->position_mm;
    case 1:
        return (double)shown->motor_position_mm;
    case 2:
        return (double)shown->current_A;
    case 3:
        return (double)shown->voltage_V;
    default:
        return (double)shown->speed_mm_s;
    }
}

/* The options stand one after the other, as the reals do. */
static int32_t* ema_fmi_option(ema_actuator_t* actuator, fmi3ValueReference reference)
{
    return (int32_t*)(void*)&actuator->options + ((size_t)reference - (size_t)EMA_FMI_OPTION);
}

const char* fmi3GetVersion(void)
{
    return "3.0";
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken,
                                         fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                         fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference requiredIntermediateVariables[],
                                         size_t nRequiredIntermediateVariables,
                                         fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
                                         fmi3IntermediateUpdateCallback intermediateUpdate)
{
    (void)instanceName;
    (void)resourcePath;
    (void)visible;
    (void)loggingOn;
    (void)eventModeUsed;
    (void)earlyReturnAllowed;
    (void)requiredIntermediateVariables;
    (void)nRequiredIntermediateVariables;
    (void)intermediateUpdate;
    const ema_fmi_t asked = {.environment = instanceEnvironment, .log = logMessage};
    if ((instantiationToken == NULL) || (strcmp(instantiationToken, EMA_FMI_TOKEN) != 0)) {
        (void)ema_fmi_fail(&asked,
                           "the modelDescription.xml is of another build than the library: pack the unit again");
        return NULL;
    }
    ema_fmi_t* const unit = malloc(sizeof *unit);
    if (unit == NULL) {
        (void)ema_fmi_fail(&asked, "no memory for an instance: %u bytes", (unsigned)sizeof *unit);
        return NULL;
    }
    *unit = asked;
    ema_fmi_begin(&unit->state);
    return unit;
}

void fmi3FreeInstance(fmi3Instance instance)
{
    free(instance);
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[])
{
    (void)loggingOn;
    (void)nCategories;
    (void)categories;
    return (instance != NULL) ? fmi3OK : fmi3Error;
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 startTime, fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{
    (void)toleranceDefined;
    (void)tolerance;
    (void)stopTimeDefined;
    (void)stopTime;
    ema_fmi_t* const unit = instance;
    if (unit == NULL) {
        return fmi3Error;
    }
    unit->state.begin_s = startTime;
    return fmi3OK;
}

/* The model of the values as they are; before it is prepared for the first time, outputs are zero. */
static fmi3Status ema_fmi_prepare(ema_fmi_t* unit)
{
    ema_fmi_state_t* const state = &unit->state;
    size_t offender = 0;
    ema_status_t status = ema_actuator_check(&state->actuator, &offender);
    if (status != EMA_OK) {
        return ema_fmi_fail(unit, "value reference %u: %s", (unsigned)(offender + (size_t)EMA_FMI_VALUE),
                            ema_status_text(status));
    }
    status = ema_model_init(&state->model, &state->actuator, (ema_real)state->start_mm);
    if (status != EMA_OK) {
        return ema_fmi_fail(unit, "the actuator's values together: %s", ema_status_text(status));
    }
    state->steps = 0;
    state->prepared = true;
    state->fresh = false;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    ema_fmi_t* const unit = instance;
    return (unit != NULL) ? ema_fmi_prepare(unit) : fmi3Error;
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    return ema_fmi_fail(instance, "fmi3EnterEventMode: the unit has no events");
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    return (instance != NULL) ? fmi3OK : fmi3Error;
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    return (instance != NULL) ? fmi3OK : fmi3Error;
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    ema_fmi_t* const unit = instance;
    if (unit == NULL) {
        return fmi3Error;
    }
    ema_fmi_begin(&unit->state);
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean* eventHandlingNeeded,
                      fmi3Boolean* terminateSimulation, fmi3Boolean* earlyReturn, fmi3Float64* lastSuccessfulTime)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    ema_fmi_t* const unit = instance;
    if ((unit == NULL) || !unit->state.prepared) {
        return ema_fmi_fail(unit, "fmi3DoStep: before fmi3ExitInitializationMode");
    }
    ema_fmi_state_t* const state = &unit->state;
    const double step_s = (double)state->actuator.params.step_s;
    const double now_steps = (currentCommunicationPoint - state->begin_s) / step_s;
    const double asked = communicationStepSize / step_s;
    const double late = now_steps - (double)state->steps;
    if (!(asked > 0.5) || !(asked < 4.0e9) || !(late < 0.01) || !(late > -0.01)) {
        return ema_fmi_fail(unit, "fmi3DoStep: from %g s by %g s: the model stands at step %.0f of %g s",
                            currentCommunicationPoint, communicationStepSize, (double)state->steps, step_s);
    }
    const uint32_t count = (uint32_t)(asked + 0.5);
    const double miss = asked - (double)count;
    if ((miss > EMA_FMI_SLACK * asked) || (-miss > EMA_FMI_SLACK * asked)) {
        return ema_fmi_fail(unit, "fmi3DoStep: %g s is no whole number of steps of %g s", communicationStepSize,
                            step_s);
    }
    const ema_real command_mm = ema_fmi_command(state);
    for (uint32_t k = 0; k < count; ++k) {
        const ema_status_t status = ema_model_step(&state->model, command_mm, NULL);
        if (status != EMA_OK) {
            return ema_fmi_fail(unit, "input %g: %s", state->input, ema_status_text(status));
        }
        ++state->steps;
    }
    state->fresh = false;
    *eventHandlingNeeded = fmi3False;
    *terminateSimulation = fmi3False;
    *earlyReturn = fmi3False;
    *lastSuccessfulTime = currentCommunicationPoint + communicationStepSize;
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Float64 values[], size_t nValues)
{
    ema_fmi_t* const unit = instance;
    if ((unit == NULL) || (nValues != nValueReferences)) {
        return ema_fmi_fail(unit, "fmi3GetFloat64: as many values as references are wanted");
    }
    ema_fmi_state_t* const state = &unit->state;
    for (size_t k = 0; k < nValues; ++k) {
        const fmi3ValueReference reference = valueReferences[k];
        ema_real value = EMA_R(0.0);
        if (reference == (fmi3ValueReference)EMA_FMI_TIME) {
            values[k] = state->begin_s + ((double)state->steps * (double)state->actuator.params.step_s);
        } else if (reference == (fmi3ValueReference)EMA_FMI_INPUT) {
            values[k] = state->input;
        } else if (reference == (fmi3ValueReference)EMA_FMI_START) {
            values[k] = state->start_mm;
        } else if (reference < (fmi3ValueReference)EMA_FMI_START) {
            if (ema_fmi_look(unit) != fmi3OK) {
                return fmi3Error;
            }
            values[k] = ema_fmi_shown(&state->shown, reference);
        } else if ((reference >= (fmi3ValueReference)EMA_FMI_VALUE)
                   && (reference < (fmi3ValueReference)EMA_FMI_OPTION)) {
            (void)ema_actuator_get(&state->actuator, (ema_value_id_t)(reference - (fmi3ValueReference)EMA_FMI_VALUE),
                                   &value);
            values[k] = (double)value;
        } else {
            return ema_fmi_fail(unit, "fmi3GetFloat64: no real value has the reference %u", (unsigned)reference);
        }
    }
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Float64 values[], size_t nValues)
{
    ema_fmi_t* const unit = instance;
    if ((unit == NULL) || (nValues != nValueReferences)) {
        return ema_fmi_fail(unit, "fmi3SetFloat64: as many values as references are wanted");
    }
    ema_fmi_state_t* const state = &unit->state;
    for (size_t k = 0; k < nValues; ++k) {
        const fmi3ValueReference reference = valueReferences[k];
        if (reference == (fmi3ValueReference)EMA_FMI_INPUT) {
            state->input = values[k];
        } else if (state->prepared) {
            return ema_fmi_fail(unit, "fmi3SetFloat64: %u is fixed once the unit is initialised", (unsigned)reference);
        } else if (reference == (fmi3ValueReference)EMA_FMI_START) {
            state->start_mm = values[k];
        } else if ((reference >= (fmi3ValueReference)EMA_FMI_VALUE)
                   && (reference < (fmi3ValueReference)EMA_FMI_OPTION)) {
            (void)ema_actuator_set(&state->actuator, (ema_value_id_t)(reference - (fmi3ValueReference)EMA_FMI_VALUE),
                                   (ema_real)values[k]);
        } else {
            return ema_fmi_fail(unit, "fmi3SetFloat64: no real value that can be set has the reference %u",
                                (unsigned)reference);
        }
    }
    state->fresh = false;
    return fmi3OK;
}

fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Int32 values[], size_t nValues)
{
    ema_fmi_t* const unit = instance;
    if ((unit == NULL) || (nValues != nValueReferences)) {
        return ema_fmi_fail(unit, "fmi3GetInt32: as many values as references are wanted");
    }
    for (size_t k = 0; k < nValues; ++k) {
        if ((valueReferences[k] < (fmi3ValueReference)EMA_FMI_OPTION)
            || (valueReferences[k] >= (fmi3ValueReference)EMA_FMI_END)) {
            return ema_fmi_fail(unit, "fmi3GetInt32: no option has the reference %u", (unsigned)valueReferences[k]);
        }
        values[k] = *ema_fmi_option(&unit->state.actuator, valueReferences[k]);
    }
    return fmi3OK;
}

fmi3Status fmi3SetInt32(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Int32 values[], size_t nValues)
{
    ema_fmi_t* const unit = instance;
    if ((unit == NULL) || (nValues != nValueReferences) || unit->state.prepared) {
        return ema_fmi_fail(unit, "fmi3SetInt32: options are set before the unit is initialised, one value each");
    }
    for (size_t k = 0; k < nValues; ++k) {
        if ((valueReferences[k] < (fmi3ValueReference)EMA_FMI_OPTION)
            || (valueReferences[k] >= (fmi3ValueReference)EMA_FMI_END)) {
            return ema_fmi_fail(unit, "fmi3SetInt32: no option has the reference %u", (unsigned)valueReferences[k]);
        }
        *ema_fmi_option(&unit->state.actuator, valueReferences[k]) = values[k];
    }
    return fmi3OK;
}

/* The standard wants a function for every type; a unit without variables of a type answers for none of them. */
#define EMA_FMI_NONE(type)                                                                                             \
    fmi3Status fmi3Get##type(fmi3Instance instance, const fmi3ValueReference valueReferences[],                        \
                             size_t nValueReferences, fmi3##type values[], size_t nValues)                             \
    {                                                                                                                  \
        (void)valueReferences;                                                                                         \
        (void)values;                                                                                                  \
        return ((nValueReferences + nValues) == 0U) ? fmi3OK                                                           \
                                                    : ema_fmi_fail(instance, "there is no variable of type " #type);   \
    }                                                                                                                  \
    fmi3Status fmi3Set##type(fmi3Instance instance, const fmi3ValueReference valueReferences[],                        \
                             size_t nValueReferences, const fmi3##type values[], size_t nValues)                       \
    {                                                                                                                  \
        (void)valueReferences;                                                                                         \
        (void)values;                                                                                                  \
        return ((nValueReferences + nValues) == 0U) ? fmi3OK                                                           \
                                                    : ema_fmi_fail(instance, "there is no variable of type " #type);   \
    }
EMA_FMI_NONE(Float32)
EMA_FMI_NONE(Int8)
EMA_FMI_NONE(UInt8)
EMA_FMI_NONE(Int16)
EMA_FMI_NONE(UInt16)
EMA_FMI_NONE(UInt32)
EMA_FMI_NONE(Int64)
EMA_FMI_NONE(UInt64)
EMA_FMI_NONE(Boolean)
EMA_FMI_NONE(String)

/* A state is a copy; learned tables are read from the instance's own actuator, whose values are fixed by then. */
fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState* FMUState)
{
    const ema_fmi_t* const unit = instance;
    if ((unit == NULL) || (FMUState == NULL)) {
        return ema_fmi_fail(unit, "fmi3GetFMUState: a place for the state is wanted");
    }
    if (*FMUState == NULL) {
        *FMUState = malloc(sizeof unit->state);
    }
    if (*FMUState == NULL) {
        return ema_fmi_fail(unit, "no memory for a state: %u bytes", (unsigned)sizeof unit->state);
    }
    (void)memcpy(*FMUState, &unit->state, sizeof unit->state);
    return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState)
{
    ema_fmi_t* const unit = instance;
    if ((unit == NULL) || (FMUState == NULL)) {
        return ema_fmi_fail(unit, "fmi3SetFMUState: a state is wanted");
    }
    (void)memcpy(&unit->state, FMUState, sizeof unit->state);
    return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState* FMUState)
{
    if ((instance == NULL) || (FMUState == NULL)) {
        return fmi3Error;
    }
    free(*FMUState);
    *FMUState = NULL;
    return fmi3OK;
}
