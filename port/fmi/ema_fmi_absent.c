/* What the standard names beyond co-simulation without events: a library has it all, and this unit refuses it.
 * Arguments are as the standard declares them and nothing reads them, so the build leaves their warning out. */
#include <stddef.h>

#include <fmi3Functions.h>

#define EMA_FMI_ABSENT(name, ...)                                                                                      \
    fmi3Status name(fmi3Instance instance, __VA_ARGS__)                                                                \
    {                                                                                                                  \
        return fmi3Error;                                                                                              \
    }
#define EMA_FMI_ABSENT_PLAIN(name)                                                                                     \
    fmi3Status name(fmi3Instance instance)                                                                             \
    {                                                                                                                  \
        return fmi3Error;                                                                                              \
    }

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage)
{
    return NULL;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String instanceName, fmi3String instantiationToken,
                                               fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                               fmi3InstanceEnvironment instanceEnvironment,
                                               fmi3LogMessageCallback logMessage, fmi3ClockUpdateCallback clockUpdate,
                                               fmi3LockPreemptionCallback lockPreemption,
                                               fmi3UnlockPreemptionCallback unlockPreemption)
{
    return NULL;
}

EMA_FMI_ABSENT(fmi3GetBinary, const fmi3ValueReference valueReferences[], size_t nValueReferences, size_t valueSizes[],
               fmi3Binary values[], size_t nValues)
EMA_FMI_ABSENT(fmi3GetClock, const fmi3ValueReference valueReferences[], size_t nValueReferences, fmi3Clock values[])
EMA_FMI_ABSENT(fmi3SetBinary, const fmi3ValueReference valueReferences[], size_t nValueReferences,
               const size_t valueSizes[], const fmi3Binary values[], size_t nValues)
EMA_FMI_ABSENT(fmi3SetClock, const fmi3ValueReference valueReferences[], size_t nValueReferences,
               const fmi3Clock values[])
EMA_FMI_ABSENT(fmi3GetNumberOfVariableDependencies, fmi3ValueReference valueReference, size_t* nDependencies)
EMA_FMI_ABSENT(fmi3GetVariableDependencies, fmi3ValueReference dependent, size_t elementIndicesOfDependent[],
               fmi3ValueReference independents[], size_t elementIndicesOfIndependents[],
               fmi3DependencyKind dependencyKinds[], size_t nDependencies)
EMA_FMI_ABSENT(fmi3SerializedFMUStateSize, fmi3FMUState FMUState, size_t* size)
EMA_FMI_ABSENT(fmi3SerializeFMUState, fmi3FMUState FMUState, fmi3Byte serializedState[], size_t size)
EMA_FMI_ABSENT(fmi3DeserializeFMUState, const fmi3Byte serializedState[], size_t size, fmi3FMUState* FMUState)
EMA_FMI_ABSENT(fmi3GetDirectionalDerivative, const fmi3ValueReference unknowns[], size_t nUnknowns,
               const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
               fmi3Float64 sensitivity[], size_t nSensitivity)
EMA_FMI_ABSENT(fmi3GetAdjointDerivative, const fmi3ValueReference unknowns[], size_t nUnknowns,
               const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
               fmi3Float64 sensitivity[], size_t nSensitivity)
EMA_FMI_ABSENT_PLAIN(fmi3EnterConfigurationMode)
EMA_FMI_ABSENT_PLAIN(fmi3ExitConfigurationMode)
EMA_FMI_ABSENT(fmi3GetIntervalDecimal, const fmi3ValueReference valueReferences[], size_t nValueReferences,
               fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
EMA_FMI_ABSENT(fmi3GetIntervalFraction, const fmi3ValueReference valueReferences[], size_t nValueReferences,
               fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
EMA_FMI_ABSENT(fmi3GetShiftDecimal, const fmi3ValueReference valueReferences[], size_t nValueReferences,
               fmi3Float64 shifts[])
EMA_FMI_ABSENT(fmi3GetShiftFraction, const fmi3ValueReference valueReferences[], size_t nValueReferences,
               fmi3UInt64 counters[], fmi3UInt64 resolutions[])
EMA_FMI_ABSENT(fmi3SetIntervalDecimal, const fmi3ValueReference valueReferences[], size_t nValueReferences,
               const fmi3Float64 intervals[])
EMA_FMI_ABSENT(fmi3SetIntervalFraction, const fmi3ValueReference valueReferences[], size_t nValueReferences,
               const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
EMA_FMI_ABSENT(fmi3SetShiftDecimal, const fmi3ValueReference valueReferences[], size_t nValueReferences,
               const fmi3Float64 shifts[])
EMA_FMI_ABSENT(fmi3SetShiftFraction, const fmi3ValueReference valueReferences[], size_t nValueReferences,
               const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
EMA_FMI_ABSENT_PLAIN(fmi3EvaluateDiscreteStates)
EMA_FMI_ABSENT(fmi3UpdateDiscreteStates, fmi3Boolean* discreteStatesNeedUpdate, fmi3Boolean* terminateSimulation,
               fmi3Boolean* nominalsOfContinuousStatesChanged, fmi3Boolean* valuesOfContinuousStatesChanged,
               fmi3Boolean* nextEventTimeDefined, fmi3Float64* nextEventTime)
EMA_FMI_ABSENT_PLAIN(fmi3EnterContinuousTimeMode)
EMA_FMI_ABSENT(fmi3CompletedIntegratorStep, fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean* enterEventMode,
               fmi3Boolean* terminateSimulation)
EMA_FMI_ABSENT(fmi3SetTime, fmi3Float64 time)
EMA_FMI_ABSENT(fmi3SetContinuousStates, const fmi3Float64 continuousStates[], size_t nContinuousStates)
EMA_FMI_ABSENT(fmi3GetContinuousStateDerivatives, fmi3Float64 derivatives[], size_t nContinuousStates)
EMA_FMI_ABSENT(fmi3GetEventIndicators, fmi3Float64 eventIndicators[], size_t nEventIndicators)
EMA_FMI_ABSENT(fmi3GetContinuousStates, fmi3Float64 continuousStates[], size_t nContinuousStates)
EMA_FMI_ABSENT(fmi3GetNominalsOfContinuousStates, fmi3Float64 nominals[], size_t nContinuousStates)
EMA_FMI_ABSENT(fmi3GetNumberOfEventIndicators, size_t* nEventIndicators)
EMA_FMI_ABSENT(fmi3GetNumberOfContinuousStates, size_t* nContinuousStates)
EMA_FMI_ABSENT(fmi3GetOutputDerivatives, const fmi3ValueReference valueReferences[], size_t nValueReferences,
               const fmi3Int32 orders[], fmi3Float64 values[], size_t nValues)
EMA_FMI_ABSENT(fmi3ActivateModelPartition, fmi3ValueReference clockReference, fmi3Float64 activationTime)
