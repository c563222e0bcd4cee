/* FMI 3.0 around the model: co-simulation@exchange_words@. */
#include "instance.c"

#include "fmi3Functions.h"

static fmi3Status refuse(fmi3Instance c, const char *message)
{
    const instance *me = c;
    if (me != NULL && me->logger != NULL && me->logging) {
        fmi3LogMessageCallback log;
        memcpy(&log, &me->logger, sizeof log);
        log(me->environment, fmi3Error, "logStatusError", message);
    }
    return fmi3Error;
}

static fmi3Instance instantiated(int continuous, fmi3String token, fmi3Boolean loggingOn,
                                 fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    instance *me;
    if (token == NULL || strcmp(token, TOKEN) != 0) {
        return NULL;
    }
    me = new_instance(continuous);
    if (me != NULL) {
        me->environment = environment;
        me->logging = loggingOn;
        memcpy(&me->logger, &log, sizeof log);
    }
    return me;
}

const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[])
{
    (void)nCategories;
    (void)categories;
    ((instance *)c)->logging = loggingOn;
    return fmi3OK;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
        fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn, fmi3InstanceEnvironment
        instanceEnvironment, fmi3LogMessageCallback logMessage)
{
    (void)instanceName;
    (void)resourcePath;
    (void)visible;
    return @exchange@ ? instantiated(1, instantiationToken, loggingOn, instanceEnvironment,
        logMessage) : NULL;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken,
        fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn, fmi3Boolean
        eventModeUsed, fmi3Boolean earlyReturnAllowed, const fmi3ValueReference
        requiredIntermediateVariables[], size_t nRequiredIntermediateVariables,
        fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
        fmi3IntermediateUpdateCallback intermediateUpdate)
{
    (void)instanceName;
    (void)resourcePath;
    (void)visible;
    (void)eventModeUsed;
    (void)earlyReturnAllowed;
    (void)requiredIntermediateVariables;
    (void)nRequiredIntermediateVariables;
    (void)intermediateUpdate;
    return instantiated(0, instantiationToken, loggingOn, instanceEnvironment, logMessage);
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String instanceName, fmi3String
        instantiationToken, fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
        fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
        fmi3ClockUpdateCallback clockUpdate, fmi3LockPreemptionCallback lockPreemption,
        fmi3UnlockPreemptionCallback unlockPreemption)
{
    (void)instanceName;
    (void)instantiationToken;
    (void)resourcePath;
    (void)visible;
    (void)loggingOn;
    (void)instanceEnvironment;
    (void)logMessage;
    (void)clockUpdate;
    (void)lockPreemption;
    (void)unlockPreemption;
    return NULL;
}

void fmi3FreeInstance(fmi3Instance c)
{
    free(c);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean toleranceDefined,
                                       fmi3Float64 tolerance, fmi3Float64 startTime, fmi3Boolean
                                       stopTimeDefined, fmi3Float64 stopTime)
{
    (void)toleranceDefined;
    (void)tolerance;
    (void)stopTimeDefined;
    (void)stopTime;
    ((instance *)c)->now.time = startTime;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c)
{
    ((instance *)c)->now.phase = RUNNING;
    return fmi3OK;
}

fmi3Status fmi3EnterEventMode(fmi3Instance c)
{
    (void)c;
    return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance c)
{
    ((instance *)c)->now.phase = ENDED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance c)
{
    reset_instance(c);
    return fmi3OK;
}

fmi3Status fmi3GetFloat32(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                          nValueReferences, fmi3Float32 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                          nValueReferences, fmi3Float64 values[], size_t nValues)
{
    if (nValues != nValueReferences) {
        return refuse(c, "fmi3GetFloat64: all variables are scalars");
    }
    for (size_t i = 0; i < nValueReferences; ++i) {
        if (!get_number(c, valueReferences[i], &values[i])) {
            return refuse(c, "fmi3GetFloat64: no such variable");
        }
    }
    return fmi3OK;
}

fmi3Status fmi3GetInt8(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                       nValueReferences, fmi3Int8 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3GetUInt8(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                        nValueReferences, fmi3UInt8 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3GetInt16(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                        nValueReferences, fmi3Int16 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3GetUInt16(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                         nValueReferences, fmi3UInt16 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3GetInt32(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                        nValueReferences, fmi3Int32 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3GetUInt32(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                         nValueReferences, fmi3UInt32 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3GetInt64(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                        nValueReferences, fmi3Int64 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3GetUInt64(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                         nValueReferences, fmi3UInt64 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3GetBoolean(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                          nValueReferences, fmi3Boolean values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3GetString(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                         nValueReferences, fmi3String values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                         nValueReferences, size_t valueSizes[], fmi3Binary values[], size_t nValues)
{
    (void)valueReferences;
    (void)valueSizes;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                        nValueReferences, fmi3Clock values[])
{
    (void)valueReferences;
    (void)values;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3SetFloat32(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                          nValueReferences, const fmi3Float32 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                          nValueReferences, const fmi3Float64 values[], size_t nValues)
{
    if (nValues != nValueReferences) {
        return refuse(c, "fmi3SetFloat64: all variables are scalars");
    }
    for (size_t i = 0; i < nValueReferences; ++i) {
        if (!set_number(c, valueReferences[i], values[i])) {
            return refuse(c, "fmi3SetFloat64: it cannot be set now, or is out of range");
        }
    }
    return fmi3OK;
}

fmi3Status fmi3SetInt8(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                       nValueReferences, const fmi3Int8 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3SetUInt8(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                        nValueReferences, const fmi3UInt8 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3SetInt16(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                        nValueReferences, const fmi3Int16 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3SetUInt16(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                         nValueReferences, const fmi3UInt16 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3SetInt32(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                        nValueReferences, const fmi3Int32 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3SetUInt32(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                         nValueReferences, const fmi3UInt32 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3SetInt64(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                        nValueReferences, const fmi3Int64 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3SetUInt64(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                         nValueReferences, const fmi3UInt64 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                          nValueReferences, const fmi3Boolean values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3SetString(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                         nValueReferences, const fmi3String values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                         nValueReferences, const size_t valueSizes[], const fmi3Binary values[],
                         size_t nValues)
{
    (void)valueReferences;
    (void)valueSizes;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t
                        nValueReferences, const fmi3Clock values[])
{
    (void)valueReferences;
    (void)values;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are Float64 variables only");
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference
        valueReference, size_t* nDependencies)
{
    (void)valueReference;
    *nDependencies = 0;
    return refuse(c, "dependencies are in the model description");
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference dependent, size_t
                                       elementIndicesOfDependent[], fmi3ValueReference
                                       independents[], size_t elementIndicesOfIndependents[],
                                       fmi3DependencyKind dependencyKinds[], size_t nDependencies)
{
    (void)dependent;
    (void)elementIndicesOfDependent;
    (void)independents;
    (void)elementIndicesOfIndependents;
    (void)dependencyKinds;
    (void)nDependencies;
    return refuse(c, "dependencies are in the model description");
}

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState* FMUState)
{
    if (*FMUState == NULL) {
        *FMUState = calloc(1, sizeof(state));
    }
    if (*FMUState == NULL) {
        return refuse(c, "no memory for the state");
    }
    memcpy(*FMUState, &((instance *)c)->now, sizeof(state));
    return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState FMUState)
{
    memcpy(&((instance *)c)->now, FMUState, sizeof(state));
    return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState* FMUState)
{
    (void)c;
    free(*FMUState);
    *FMUState = NULL;
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState FMUState, size_t* size)
{
    (void)c;
    (void)FMUState;
    *size = sizeof(state);
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState FMUState, fmi3Byte
                                 serializedState[], size_t size)
{
    if (size < sizeof(state)) {
        return refuse(c, "too little room for the state");
    }
    memcpy(serializedState, FMUState, sizeof(state));
    return fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte serializedState[], size_t
                                   size, fmi3FMUState* FMUState)
{
    if (size != sizeof(state)) {
        return refuse(c, "a serialised state of another size");
    }
    if (*FMUState == NULL) {
        *FMUState = calloc(1, sizeof(state));
    }
    if (*FMUState == NULL) {
        return refuse(c, "no memory for the state");
    }
    memcpy(*FMUState, serializedState, sizeof(state));
    return fmi3OK;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknowns[],
        size_t nUnknowns, const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64
        seed[], size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
{
    (void)unknowns;
    (void)nUnknowns;
    (void)knowns;
    (void)nKnowns;
    (void)seed;
    (void)nSeed;
    (void)sensitivity;
    (void)nSensitivity;
    return refuse(c, "there are no directional derivatives");
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference unknowns[],
                                    size_t nUnknowns, const fmi3ValueReference knowns[], size_t
                                    nKnowns, const fmi3Float64 seed[], size_t nSeed, fmi3Float64
                                    sensitivity[], size_t nSensitivity)
{
    (void)unknowns;
    (void)nUnknowns;
    (void)knowns;
    (void)nKnowns;
    (void)seed;
    (void)nSeed;
    (void)sensitivity;
    (void)nSensitivity;
    return refuse(c, "there are no directional derivatives");
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance c)
{
    return refuse(c, "there are no structural parameters");
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance c)
{
    return refuse(c, "there are no structural parameters");
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, const fmi3ValueReference
                                  valueReferences[], size_t nValueReferences, fmi3Float64
                                  intervals[], fmi3IntervalQualifier qualifiers[])
{
    (void)valueReferences;
    (void)intervals;
    (void)qualifiers;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are no clocks");
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance c, const fmi3ValueReference
                                   valueReferences[], size_t nValueReferences, fmi3UInt64
                                   counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier
                                   qualifiers[])
{
    (void)valueReferences;
    (void)counters;
    (void)resolutions;
    (void)qualifiers;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are no clocks");
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance c, const fmi3ValueReference valueReferences[],
                               size_t nValueReferences, fmi3Float64 shifts[])
{
    (void)valueReferences;
    (void)shifts;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are no clocks");
}

fmi3Status fmi3GetShiftFraction(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                size_t nValueReferences, fmi3UInt64 counters[], fmi3UInt64
                                resolutions[])
{
    (void)valueReferences;
    (void)counters;
    (void)resolutions;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are no clocks");
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance c, const fmi3ValueReference
                                  valueReferences[], size_t nValueReferences, const fmi3Float64
                                  intervals[])
{
    (void)valueReferences;
    (void)intervals;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are no clocks");
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance c, const fmi3ValueReference
                                   valueReferences[], size_t nValueReferences, const fmi3UInt64
                                   counters[], const fmi3UInt64 resolutions[])
{
    (void)valueReferences;
    (void)counters;
    (void)resolutions;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are no clocks");
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance c, const fmi3ValueReference valueReferences[],
                               size_t nValueReferences, const fmi3Float64 shifts[])
{
    (void)valueReferences;
    (void)shifts;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are no clocks");
}

fmi3Status fmi3SetShiftFraction(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                size_t nValueReferences, const fmi3UInt64 counters[], const
                                fmi3UInt64 resolutions[])
{
    (void)valueReferences;
    (void)counters;
    (void)resolutions;
    return nValueReferences == 0 ? fmi3OK : refuse(c, "there are no clocks");
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c)
{
    (void)c;
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean* discreteStatesNeedUpdate,
                                    fmi3Boolean* terminateSimulation, fmi3Boolean*
                                    nominalsOfContinuousStatesChanged, fmi3Boolean*
                                    valuesOfContinuousStatesChanged, fmi3Boolean*
                                    nextEventTimeDefined, fmi3Float64* nextEventTime)
{
    (void)c;
    *discreteStatesNeedUpdate = false;
    *terminateSimulation = false;
    *nominalsOfContinuousStatesChanged = false;
    *valuesOfContinuousStatesChanged = false;
    *nextEventTimeDefined = false;
    *nextEventTime = 0.0;
    return fmi3OK;
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c)
{
    (void)c;
    return fmi3OK;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean
                                       noSetFMUStatePriorToCurrentPoint, fmi3Boolean*
                                       enterEventMode, fmi3Boolean* terminateSimulation)
{
    (void)c;
    (void)noSetFMUStatePriorToCurrentPoint;
    *enterEventMode = false;
    *terminateSimulation = false;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 time)
{
    ((instance *)c)->now.time = time;
    return fmi3OK;
}

fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 continuousStates[],
                                   size_t nContinuousStates)
{
    if (nContinuousStates != 2) {
        return refuse(c, "there are two continuous states");
    }
    memcpy(((instance *)c)->now.model.motion.f0.v, continuousStates, 2 * sizeof
        *continuousStates);
    return fmi3OK;
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 derivatives[],
        size_t nContinuousStates)
{
    if (nContinuousStates != 2) {
        return refuse(c, "there are two continuous states");
    }
    derivatives[0] = ((instance *)c)->now.model.motion.f0.v[1];
    derivatives[1] = acceleration(&((instance *)c)->now);
    return fmi3OK;
}

fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 eventIndicators[], size_t
                                  nEventIndicators)
{
    (void)eventIndicators;
    return nEventIndicators == 0 ? fmi3OK : refuse(c, "there are no event indicators");
}

fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 continuousStates[], size_t
                                   nContinuousStates)
{
    if (nContinuousStates != 2) {
        return refuse(c, "there are two continuous states");
    }
    memcpy(continuousStates, ((instance *)c)->now.model.motion.f0.v, 2 * sizeof
        *continuousStates);
    return fmi3OK;
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 nominals[], size_t
        nContinuousStates)
{
    if (nContinuousStates != 2) {
        return refuse(c, "there are two continuous states");
    }
    nominals[0] = @nominal_angle@;
    nominals[1] = @nominal_speed@;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t* nEventIndicators)
{
    (void)c;
    *nEventIndicators = 0;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t* nContinuousStates)
{
    *nContinuousStates = ((instance *)c)->now.continuous ? 2 : 0;
    return fmi3OK;
}

fmi3Status fmi3EnterStepMode(fmi3Instance c)
{
    (void)c;
    return fmi3OK;
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference
                                    valueReferences[], size_t nValueReferences, const fmi3Int32
                                    orders[], fmi3Float64 values[], size_t nValues)
{
    (void)valueReferences;
    (void)orders;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : refuse(c,
                    "there are no derivatives of outputs");
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 currentCommunicationPoint, fmi3Float64
                      communicationStepSize, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                      fmi3Boolean* eventHandlingNeeded, fmi3Boolean* terminateSimulation,
                      fmi3Boolean* earlyReturn, fmi3Float64* lastSuccessfulTime)
{
    instance *me = c;
    int status;
    (void)noSetFMUStatePriorToCurrentPoint;
    *eventHandlingNeeded = false;
    *terminateSimulation = false;
    *earlyReturn = false;
    *lastSuccessfulTime = currentCommunicationPoint;
    if (me->now.phase != RUNNING || me->now.continuous) {
        return refuse(me, "fmi3DoStep: not in step mode");
    }
    status = @name@_step(&me->now.model, me->now.command, communicationStepSize);
    if (status != @NAME@_OK) {
        return refuse(me, step_error(status));
    }
    me->now.time = currentCommunicationPoint + communicationStepSize;
    *lastSuccessfulTime = me->now.time;
    return fmi3OK;
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference clockReference,
                                      fmi3Float64 activationTime)
{
    (void)clockReference;
    (void)activationTime;
    return refuse(c, "there are no clocks");
}
