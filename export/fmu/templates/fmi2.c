/* FMI 2.0 around the model: co-simulation@exchange_words@. */
#include "instance.c"

#include "fmi2Functions.h"

static fmi2Status refuse(fmi2Component c, const char *message)
{
    const instance *me = c;
    const fmi2CallbackFunctions *callbacks = me == NULL ? NULL : me->logger;
    if (callbacks != NULL && callbacks->logger != NULL && me->logging) {
        callbacks->logger(callbacks->componentEnvironment, "@name@", fmi2Error, "logStatusError",
                          "%s", message);
    }
    return fmi2Error;
}

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[])
{
    (void)nCategories;
    (void)categories;
    ((instance *)c)->logging = loggingOn;
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean loggingOn)
{
    instance *me;
    (void)instanceName;
    (void)fmuResourceLocation;
    (void)visible;
    if (fmuGUID == NULL || strcmp(fmuGUID, TOKEN) != 0) {
        return NULL;
    }
    if (fmuType != fmi2CoSimulation && !@exchange@) {
        return NULL;
    }
    me = new_instance(fmuType == fmi2ModelExchange);
    if (me != NULL && functions != NULL) {
        fmi2CallbackFunctions *kept = malloc(sizeof *kept);
        if (kept != NULL) {
            memcpy(kept, functions, sizeof *kept);
        }
        me->logger = kept;
        me->logging = loggingOn;
    }
    return me;
}

void fmi2FreeInstance(fmi2Component c)
{
    if (c != NULL) {
        free(((instance *)c)->logger);
        free(c);
    }
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance,
                               fmi2Real startTime, fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    (void)toleranceDefined;
    (void)tolerance;
    (void)stopTimeDefined;
    (void)stopTime;
    ((instance *)c)->now.time = startTime;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    ((instance *)c)->now.phase = RUNNING;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    ((instance *)c)->now.phase = ENDED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    reset_instance(c);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[])
{
    for (size_t i = 0; i < nvr; ++i) {
        if (!get_number(c, vr[i], &value[i])) {
            return refuse(c, "fmi2GetReal: no such variable");
        }
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                       const fmi2Real value[])
{
    for (size_t i = 0; i < nvr; ++i) {
        if (!set_number(c, vr[i], value[i])) {
            return refuse(c, "fmi2SetReal: it cannot be set now, or is out of range");
        }
    }
    return fmi2OK;
}

#define NONE_OF(type)                                                                              \
    fmi2Status fmi2Get##type(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,           \
                             fmi2##type value[])                                                   \
    {                                                                                              \
        (void)vr;                                                                                  \
        (void)value;                                                                               \
        return nvr == 0 ? fmi2OK : refuse(c, "there are Real variables only");                     \
    }                                                                                              \
    fmi2Status fmi2Set##type(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,           \
                             const fmi2##type value[])                                             \
    {                                                                                              \
        (void)vr;                                                                                  \
        (void)value;                                                                               \
        return nvr == 0 ? fmi2OK : refuse(c, "there are Real variables only");                     \
    }

NONE_OF(Integer)
NONE_OF(Boolean)
NONE_OF(String)

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    if (*FMUstate == NULL) {
        *FMUstate = calloc(1, sizeof(state));
    }
    if (*FMUstate == NULL) {
        return refuse(c, "no memory for the state");
    }
    memcpy(*FMUstate, &((instance *)c)->now, sizeof(state));
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate)
{
    memcpy(&((instance *)c)->now, FMUstate, sizeof(state));
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    (void)c;
    free(*FMUstate);
    *FMUstate = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size)
{
    (void)c;
    (void)FMUstate;
    *size = sizeof(state);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate,
                                 fmi2Byte serializedState[], size_t size)
{
    if (size < sizeof(state)) {
        return refuse(c, "too little room for the state");
    }
    memcpy(serializedState, FMUstate, sizeof(state));
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate *FMUstate)
{
    if (size != sizeof(state)) {
        return refuse(c, "a serialised state of another size");
    }
    if (*FMUstate == NULL) {
        *FMUstate = calloc(1, sizeof(state));
    }
    if (*FMUstate == NULL) {
        return refuse(c, "no memory for the state");
    }
    memcpy(*FMUstate, serializedState, sizeof(state));
    return fmi2OK;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown_ref[],
                                        size_t nUnknown, const fmi2ValueReference vKnown_ref[],
                                        size_t nKnown, const fmi2Real dvKnown[],
                                        fmi2Real dvUnknown[])
{
    (void)vUnknown_ref;
    (void)nUnknown;
    (void)vKnown_ref;
    (void)nKnown;
    (void)dvKnown;
    (void)dvUnknown;
    return refuse(c, "there are no directional derivatives");
}

/* Model exchange */

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *fmi2eventInfo)
{
    (void)c;
    memset(fmi2eventInfo, 0, sizeof *fmi2eventInfo);
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c,
                                       fmi2Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi2Boolean *enterEventMode,
                                       fmi2Boolean *terminateSimulation)
{
    (void)c;
    (void)noSetFMUStatePriorToCurrentPoint;
    *enterEventMode = fmi2False;
    *terminateSimulation = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    ((instance *)c)->now.time = time;
    return fmi2OK;
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx)
{
    if (nx != 2) {
        return refuse(c, "there are two continuous states");
    }
    memcpy(((instance *)c)->now.model.motion.f0.v, x, 2 * sizeof *x);
    return fmi2OK;
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx)
{
    const instance *me = c;
    if (nx != 2) {
        return refuse(c, "there are two continuous states");
    }
    derivatives[0] = me->now.model.motion.f0.v[1];
    derivatives[1] = acceleration(&me->now);
    return fmi2OK;
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni)
{
    (void)eventIndicators;
    return ni == 0 ? fmi2OK : refuse(c, "there are no event indicators");
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx)
{
    if (nx != 2) {
        return refuse(c, "there are two continuous states");
    }
    memcpy(x, ((const instance *)c)->now.model.motion.f0.v, 2 * sizeof *x);
    return fmi2OK;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx)
{
    if (nx != 2) {
        return refuse(c, "there are two continuous states");
    }
    x_nominal[0] = @nominal_angle@;
    x_nominal[1] = @nominal_speed@;
    return fmi2OK;
}

/* Co-simulation */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    (void)vr;
    (void)order;
    (void)value;
    return nvr == 0 ? fmi2OK : refuse(c, "the command holds through a step");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[])
{
    (void)vr;
    (void)order;
    (void)value;
    return nvr == 0 ? fmi2OK : refuse(c, "there are no derivatives of outputs");
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint,
                      fmi2Real communicationStepSize, fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    instance *me = c;
    int status;
    (void)noSetFMUStatePriorToCurrentPoint;
    if (me->now.phase != RUNNING || me->now.continuous) {
        return refuse(c, "fmi2DoStep: not in step mode");
    }
    status = @name@_step(&me->now.model, me->now.command, communicationStepSize);
    if (status != @NAME@_OK) {
        return refuse(c, step_error(status));
    }
    me->now.time = currentCommunicationPoint + communicationStepSize;
    return fmi2OK;
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    return refuse(c, "steps are not asynchronous");
}

#define STATUS_OF(name, type)                                                                      \
    fmi2Status fmi2Get##name(fmi2Component c, const fmi2StatusKind s, type *value)                 \
    {                                                                                              \
        (void)s;                                                                                   \
        (void)value;                                                                               \
        return refuse(c, "steps are not asynchronous");                                            \
    }

STATUS_OF(Status, fmi2Status)
STATUS_OF(RealStatus, fmi2Real)
STATUS_OF(IntegerStatus, fmi2Integer)
STATUS_OF(BooleanStatus, fmi2Boolean)
STATUS_OF(StringStatus, fmi2String)
