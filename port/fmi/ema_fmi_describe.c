/* Writes modelDescription.xml of a co-simulation unit to standard output, from ema_params.def and ema_effects.def.
 * Functional Mock-up Interface Specification 3.0.2, Modelica Association 2024, section 2.4. Arguments: the name of its
 * library, the version, the token. */
#include <stdio.h>

#include "ema_fmi_list.h"

typedef struct {
    int shown;
    int is_option;
    const char* section;
    const char* effect; /* empty, or the effect whose value it is */
    const char* field;
    const char* text;
    double nominal;
    double lower;
    double upper;
} ema_fmi_row_t;

#define EMA_PARAM(section, field, nominal, lower, upper, text)                                                         \
    {EMA_FMI_SHOWS_##section, 0, #section, "", #field, text, nominal, lower, upper},
static const ema_fmi_row_t ema_fmi_params[] = {
#include "ema/ema_params.def"
};

#define EMA_OPTION(section, field, nominal, lower, upper, choices, text)                                               \
    {EMA_FMI_SHOWS_##section, 1, #section, "", #field, choices[0] ? text ": " choices : text, nominal, lower, upper},
static const ema_fmi_row_t ema_fmi_options[] = {
#include "ema/ema_params.def"
};

/* The values of an effect do not know its name: they are told by their place. */
typedef struct {
    const char* name;
    size_t values;
} ema_fmi_effect_t;

#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters)                            \
    {#name, sizeof(ema_effect_##name##_t) / sizeof(ema_real)},
static const ema_fmi_effect_t ema_fmi_effects[] = {
#include "ema/ema_effects.def"
};

#define EMA_P(field, nominal, lower, upper, text) {1, 0, "effects", "", #field, text, nominal, lower, upper},
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters) parameters
static const ema_fmi_row_t ema_fmi_values[] = {
#include "ema/ema_effects.def"
};

static void ema_fmi_text(const char* text)
{
    for (const char* at = text; *at != '\0'; ++at) {
        switch (*at) {
        case '&':
            (void)fputs("&amp;", stdout);
            break;
        case '<':
            (void)fputs("&lt;", stdout);
            break;
        case '"':
            (void)fputs("&quot;", stdout);
            break;
        default:
            (void)putchar(*at);
            break;
        }
    }
}

static void ema_fmi_row(const ema_fmi_row_t* row, const char* effect, int reference)
{
    if (row->shown == 0) {
        return;
    }
    (void)printf("    <%s name=\"%s.%s%s%s\" valueReference=\"%d\" causality=\"parameter\" variability=\"fixed\"",
                 (row->is_option != 0) ? "Int32" : "Float64", row->section, effect, (effect[0] != '\0') ? "." : "",
                 row->field, reference);
    (void)printf(" start=\"%.17g\" min=\"%.17g\" max=\"%.17g\" description=\"", row->nominal, row->lower, row->upper);
    ema_fmi_text(row->text);
    (void)fputs("\"/>\n", stdout);
}

static void ema_fmi_variables(void)
{
    static const char* const outputs[EMA_FMI_OUTPUTS][2] = {
        {"position_mm", "rod, as its sensor reads it"},
        {"motor_position_mm", "motor encoder expressed at the rod"},
        {"current_A", "of the motor"},
        {"voltage_V", "applied from now on, by the present input"},
        {"speed_mm_s", "of the rod"},
    };
    (void)printf("    <Float64 name=\"time\" valueReference=\"%d\" causality=\"independent\" variability=\"continuous\""
                 " description=\"s\"/>\n",
                 (int)EMA_FMI_TIME);
    (void)printf(
        "    <Float64 name=\"%s\" valueReference=\"%d\" causality=\"input\" variability=\"discrete\" start=\"0\""
        " description=\"%s\"/>\n",
        EMA_FMI_PLANT ? "output_share" : "command_mm", (int)EMA_FMI_INPUT,
        EMA_FMI_PLANT ? "the drive's output over its full one" : "commanded position, held over the step");
    for (int k = 0; k < (int)EMA_FMI_OUTPUTS; ++k) {
        (void)printf("    <Float64 name=\"%s\" valueReference=\"%d\" causality=\"output\" variability=\"discrete\""
                     " initial=\"calculated\" description=\"%s\"/>\n",
                     outputs[k][0], (int)EMA_FMI_POSITION + k, outputs[k][1]);
    }
    (void)printf(
        "    <Float64 name=\"start_mm\" valueReference=\"%d\" causality=\"parameter\" variability=\"fixed\" start=\"0\""
        " description=\"where rod and motor rest at the start\"/>\n",
        (int)EMA_FMI_START);
    int reference = (int)EMA_FMI_VALUE;
    for (size_t k = 0; k < EMA_PARAM_COUNT; ++k) {
        ema_fmi_row(&ema_fmi_params[k], "", reference++);
    }
    size_t value = 0;
    for (size_t effect = 0; effect < (size_t)EMA_EFFECT_COUNT; ++effect) {
        for (size_t k = 0; k < ema_fmi_effects[effect].values; ++k) {
            ema_fmi_row(&ema_fmi_values[value++], ema_fmi_effects[effect].name, reference++);
        }
    }
    for (size_t k = 0; k < EMA_OPTION_COUNT; ++k) {
        ema_fmi_row(&ema_fmi_options[k], "", reference++);
    }
}

int main(int count, char** words)
{
    if (count != 4) {
        (void)fputs("usage: ema_fmi_describe NAME VERSION TOKEN\n", stderr);
        return 2;
    }
    const double step_s = (double)ema_actuator_range(EMA_VALUE_ID(step_s))->nominal;
    (void)printf("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
                 "<fmiModelDescription fmiVersion=\"3.0\" modelName=\"%s\" version=\"%s\" instantiationToken=\"%s\"\n"
                 "    description=\"Electromechanical actuator%s\" variableNamingConvention=\"structured\">\n"
                 "  <CoSimulation modelIdentifier=\"%s\" canHandleVariableCommunicationStepSize=\"false\""
                 " canGetAndSetFMUState=\"true\"/>\n"
                 "  <DefaultExperiment startTime=\"0\" stopTime=\"1\" stepSize=\"%.17g\"/>\n  <ModelVariables>\n",
                 words[1], words[2], words[3], EMA_FMI_PLANT ? ", without its controller" : " with its controller",
                 words[1], step_s);
    ema_fmi_variables();
    (void)fputs("  </ModelVariables>\n  <ModelStructure>\n", stdout);
    for (int k = 0; k < (int)EMA_FMI_OUTPUTS; ++k) {
        (void)printf("    <Output valueReference=\"%d\"/>\n", (int)EMA_FMI_POSITION + k);
    }
    for (int k = 0; k < (int)EMA_FMI_OUTPUTS; ++k) {
        (void)printf("    <InitialUnknown valueReference=\"%d\"/>\n", (int)EMA_FMI_POSITION + k);
    }
    (void)fputs("  </ModelStructure>\n</fmiModelDescription>\n", stdout);
    return (fflush(stdout) == 0) ? 0 : 1;
}
