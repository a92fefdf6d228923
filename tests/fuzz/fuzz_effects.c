/* Effects with any values of their ranges, several at once: every row is finite or the model says that it diverged; an
 * effect at zero is not there, bit for bit; a copy goes on as the model itself does. */
#include "ema/ema.h"
#include "ema_fuzz.h"

#define STEPS 16U
#define COPIED_AT 3U

/* Integration steps of one input: a model that needs many makes fewer steps, so that inputs stay short. */
#define SUBSTEPS 64U

typedef struct {
    size_t first; /* id of its first value */
    size_t count;
} effect_t;

#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters)                            \
    {EMA_PARAM_COUNT + (offsetof(ema_effects_t, name) / sizeof(ema_real)),                                             \
     sizeof(ema_effect_##name##_t) / sizeof(ema_real)},
static const effect_t effects[] = {
#include "ema/ema_effects.def"
};

#define EFFECTS (sizeof effects / sizeof effects[0])

/* Sets the values of one effect; its first is zero where the effect is to be absent. */
static void set_effect(fuzz_bytes_t* bytes, ema_actuator_t* actuator, const effect_t* effect, bool absent)
{
    for (size_t k = 0; k < effect->count; ++k) {
        const size_t id = effect->first + k;
        const ema_real value = (absent && (k == 0U)) ? EMA_R(0.0) : fuzz_within(bytes, ema_actuator_range(id));
        FUZZ_REQUIRE(ema_actuator_set(actuator, (ema_value_id_t)id, value) == EMA_OK);
    }
}

static bool same_bits(const ema_output_t* a, const ema_output_t* b)
{
    return memcmp(a, b, sizeof *a) == 0;
}

static bool output_finite(const ema_output_t* output)
{
    return fuzz_finite(output->position_mm) && fuzz_finite(output->motor_position_mm) && fuzz_finite(output->current_A)
           && fuzz_finite(output->voltage_V) && fuzz_finite(output->speed_mm_s);
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    static ema_model_t model;
    static ema_model_t other;
    fuzz_bytes_t bytes = {data, size};
    ema_actuator_t actuator;
    FUZZ_REQUIRE(ema_actuator_defaults(&actuator) == EMA_OK);
    const uint8_t head = fuzz_u8(&bytes);
    actuator.options.mode = head & 1;
    actuator.options.side = (head >> 1) & 1;
    actuator.options.structure = (head >> 2) & 1;
    actuator.params.current_scale_A = EMA_R(10.0);
    actuator.params.speed_gain_s_per_m = EMA_R(1.0);
    actuator.params.position_gain_per_s = EMA_R(20.0);
    const uint32_t present = 1U + ((uint32_t)(head >> 3) & 3U);
    for (uint32_t k = 0; k < present; ++k) {
        set_effect(&bytes, &actuator, &effects[fuzz_u8(&bytes) % EFFECTS], false);
    }
    ema_actuator_t twin = actuator;
    const effect_t* const absent = &effects[fuzz_u8(&bytes) % EFFECTS];
    ema_real first = EMA_R(0.0);
    FUZZ_REQUIRE(ema_actuator_get(&actuator, (ema_value_id_t)absent->first, &first) == EMA_OK);
    if (first == EMA_R(0.0)) {
        set_effect(&bytes, &twin, absent, true);
    }
    const ema_real start_mm = (fuzz_share(&bytes) - EMA_R(0.5)) * EMA_R(50.0);
    ema_status_t status = ema_model_init(&model, &actuator, start_mm);
    FUZZ_REQUIRE(ema_model_init(&other, &twin, start_mm) == status);
    bool copied = false;
    for (uint32_t k = 0; (k < STEPS) && ((k * model.plant.substeps) <= SUBSTEPS) && (status == EMA_OK); ++k) {
        const ema_real command_mm = start_mm + (((ema_real)fuzz_u8(&bytes) - EMA_R(128.0)) * EMA_R(0.2));
        ema_output_t output = {0};
        ema_output_t output_twin = {0};
        status = ema_model_step(&model, command_mm, &output);
        FUZZ_REQUIRE(ema_model_step(&other, command_mm, &output_twin) == status);
        FUZZ_REQUIRE((status == EMA_ERR_DIVERGED) || ((status == EMA_OK) && output_finite(&output)));
        FUZZ_REQUIRE((status != EMA_OK) || same_bits(&output, &output_twin));
        if (!copied && (k >= COPIED_AT)) {
            /* the rest is made by a copy; the original is gone */
            (void)memcpy(&other, &model, sizeof other);
            copied = true;
        }
    }
    return 0;
}
