/* Parts that are called on their own against the stored reference: the control law, the commands, the random numbers.
 * Tolerances and why: tests/vectors/manifest.json.
 */
#include "blocks/ema_pid.h"
#include "ema/ema.h"
#include "ema_rig.h"

/* The bits of an ema_real, as the tables hold them. */
#if EMA_REAL64
typedef uint64_t ema_vec_bits_t;
#else
typedef uint32_t ema_vec_bits_t;
#endif

#include "ema_vec_commands.inc"
#include "ema_vec_pid.inc"
#include "ema_vec_random.inc"

void setUp(void)
{
}

void tearDown(void)
{
}

static ema_real number(ema_vec_bits_t bits)
{
    ema_real value;
    (void)memcpy(&value, &bits, sizeof value);
    return value;
}

#define SET_VALUE(section, field, value) actuator.params.field = EMA_R(value);
#define SET_OPTION(section, field, value) actuator.options.field = (value);
#define SET_EFFECT(name, field, value) actuator.effects.name.field = EMA_R(value);

/* The control law alone, one run per row. */
static void assert_pid(const ema_actuator_t* actuator, const ema_vec_bits_t (*bits)[3])
{
    ema_pid_t pid;
    ema_state_t state = {0};
    ema_pid_prepare(&pid, &actuator->params, &actuator->options);
    for (uint32_t run = 0; run < EMA_VEC_PID_RUNS; ++run) {
        const ema_real output = ema_pid_step(&pid, &state, number(bits[run][0]), number(bits[run][1]));
        EMA_ASSERT_CLOSE(number(bits[run][2]), output, (double)EMA_VEC_PID_TOLERANCE, 0.0);
        ++state.step;
    }
}

#define PID_TEST(case_name, CASE)                                                                                      \
    static void test_pid_##case_name(void)                                                                             \
    {                                                                                                                  \
        ema_actuator_t actuator = ema_rig_actuator();                                                                  \
        actuator.params.step_s = EMA_VEC_PID_PERIOD_S;                                                                 \
        EMA_VEC_PID_##CASE##_OVERRIDES(SET_VALUE) EMA_VEC_PID_##CASE##_OPTIONS(SET_OPTION)                             \
            EMA_VEC_PID_##CASE##_EFFECTS(SET_EFFECT) assert_pid(&actuator, ema_vec_pid_##case_name##_bits);            \
    }
EMA_VEC_PID_CASES(PID_TEST)

#define COMMAND_TEST(case_name, CASE)                                                                                  \
    static void test_command_##case_name(void)                                                                         \
    {                                                                                                                  \
        const ema_command_config_t config = EMA_VEC_COMMAND_##CASE##_CONFIG;                                           \
        ema_command_t command;                                                                                         \
        EMA_ASSERT_STATUS(EMA_OK, ema_command_init(&command, &config, EMA_VEC_COMMAND_STEP_S));                        \
        for (uint32_t row = 0; row < EMA_VEC_COMMAND_ROWS; ++row) {                                                    \
            const ema_real expected = number(ema_vec_command_##case_name##_bits[row][0]);                              \
            const ema_real actual = ema_command_at(&command, row * EMA_VEC_COMMAND_##CASE##_EVERY);                    \
            EMA_ASSERT_CLOSE(expected, actual, (double)EMA_VEC_COMMAND_##CASE##_TOLERANCE_MM, 0.0);                    \
        }                                                                                                              \
    }
EMA_VEC_COMMAND_CASES(COMMAND_TEST)

/* Words are equal, uniforms are equal bit for bit, normals within their tolerance; each from a fresh start. */
#define RANDOM_TEST(index, seed, stream)                                                                               \
    static void test_random_##index(void)                                                                              \
    {                                                                                                                  \
        ema_random_t words;                                                                                            \
        ema_random_t uniforms;                                                                                         \
        ema_random_t normals;                                                                                          \
        ema_random_init(&words, (seed), (stream));                                                                     \
        ema_random_init(&uniforms, (seed), (stream));                                                                  \
        ema_random_init(&normals, (seed), (stream));                                                                   \
        for (uint32_t draw = 0; draw < EMA_VEC_RANDOM_DRAWS; ++draw) {                                                 \
            TEST_ASSERT_EQUAL_HEX32(ema_vec_random_##index##_words[draw], ema_random_u32(&words));                     \
            TEST_ASSERT_TRUE(number(ema_vec_random_##index##_bits[draw][0]) == ema_random_uniform(&uniforms));         \
            EMA_ASSERT_CLOSE(number(ema_vec_random_##index##_bits[draw][1]), ema_random_normal(&normals),              \
                             (double)EMA_VEC_RANDOM_NORMAL_TOLERANCE, 0.0);                                            \
        }                                                                                                              \
    }
EMA_VEC_RANDOM_CASES(RANDOM_TEST)

int main(void)
{
    UNITY_BEGIN();
#define RUN_PID(case_name, CASE) RUN_TEST(test_pid_##case_name);
    EMA_VEC_PID_CASES(RUN_PID)
#define RUN_COMMAND(case_name, CASE) RUN_TEST(test_command_##case_name);
    EMA_VEC_COMMAND_CASES(RUN_COMMAND)
#define RUN_RANDOM(index, seed, stream) RUN_TEST(test_random_##index);
    EMA_VEC_RANDOM_CASES(RUN_RANDOM)
    return UNITY_END();
}
