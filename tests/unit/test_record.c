/* The record: what goes in comes out within half a count, in either format, and what does not fit is refused. */
#include <float.h>
#include <math.h>

#include "ema/ema.h"
#include "ema_rig.h"

#define ROWS 50U

static ema_real memory[5U * ROWS];
static ema_record_config_t config;
static ema_record_t record;

void setUp(void)
{
    ema_rig_seed(10U);
    (void)memset(memory, 0, sizeof memory);
    config = ema_rig_real_record(memory, sizeof memory, true);
}

void tearDown(void)
{
}

static void use_int16(void)
{
    config.format = EMA_RECORD_INT16;
    config.command_full_scale_mm = EMA_R(2.5);
    config.full_scale[EMA_CHANNEL_POSITION] = EMA_R(3.0);
    config.full_scale[EMA_CHANNEL_MOTOR_POSITION] = EMA_R(4.0);
    config.full_scale[EMA_CHANNEL_CURRENT] = EMA_R(25.0);
    config.full_scale[EMA_CHANNEL_VOLTAGE] = EMA_R(30.0);
}

static void start(void)
{
    EMA_ASSERT_STATUS(EMA_OK, ema_record_init(&record, &config));
}

static ema_sample_t random_sample(void)
{
    const ema_sample_t sample = {ema_rig_uniform(EMA_R(-2.5), EMA_R(2.5)),
                                 {ema_rig_uniform(EMA_R(-3.0), EMA_R(3.0)), ema_rig_uniform(EMA_R(-4.0), EMA_R(4.0)),
                                  ema_rig_uniform(EMA_R(-25.0), EMA_R(25.0)),
                                  ema_rig_uniform(EMA_R(-30.0), EMA_R(30.0))}};
    return sample;
}

/* Half a count of an int16 at a full scale, and the rounding of its product. */
static double half_count(double full_scale)
{
    return full_scale * ((0.5 / 32767.0) + (4.0 * EMA_EPS));
}

static void test_reals_come_back_exactly(void)
{
    ema_sample_t sent[ROWS];
    start();
    TEST_ASSERT_EQUAL_UINT32(ROWS, record.capacity);
    for (uint32_t row = 0; row < ROWS; ++row) {
        sent[row] = random_sample();
        EMA_ASSERT_STATUS(EMA_OK, ema_record_append(&record, &sent[row]));
        TEST_ASSERT_EQUAL_UINT32(row + 1U, record.count);
    }
    for (uint32_t row = 0; row < ROWS; ++row) {
        ema_sample_t read;
        EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&record, row, 1U, &read));
        EMA_ASSERT_SAME_BITS(&sent[row], &read, sizeof read);
    }
}

static void test_int16_comes_back_within_half_a_count(void)
{
    ema_sample_t sent[ROWS];
    const double scale[5] = {2.5, 3.0, 4.0, 25.0, 30.0};
    double used = 0.0;
    use_int16();
    start();
    TEST_ASSERT_TRUE(record.capacity >= ROWS);
    for (uint32_t row = 0; row < ROWS; ++row) {
        sent[row] = random_sample();
        EMA_ASSERT_STATUS(EMA_OK, ema_record_append(&record, &sent[row]));
    }
    for (uint32_t row = 0; row < ROWS; ++row) {
        ema_sample_t read;
        EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&record, row, 1U, &read));
        EMA_ASSERT_CLOSE(sent[row].command_mm, read.command_mm, half_count(scale[0]), 0.0);
        for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
            EMA_ASSERT_CLOSE(sent[row].channel[channel], read.channel[channel], half_count(scale[1U + channel]), 0.0);
            used = fmax(used,
                        fabs((double)sent[row].channel[channel] - (double)read.channel[channel]) / scale[1U + channel]);
        }
    }
    /* it is int16 indeed: some value is off by more than a quarter of a count */
    TEST_ASSERT_TRUE(used > (0.25 / 32767.0));
}

static void test_int16_keeps_full_scale_on_both_sides_and_zero(void)
{
    use_int16();
    start();
    const ema_sample_t top = {EMA_R(2.5), {EMA_R(3.0), EMA_R(4.0), EMA_R(25.0), EMA_R(30.0)}};
    const ema_sample_t bottom = {EMA_R(-2.5), {EMA_R(-3.0), EMA_R(-4.0), EMA_R(-25.0), EMA_R(-30.0)}};
    const ema_sample_t zero = {EMA_R(0.0), {EMA_R(0.0)}};
    ema_sample_t read;
    EMA_ASSERT_STATUS(EMA_OK, ema_record_append(&record, &top));
    EMA_ASSERT_STATUS(EMA_OK, ema_record_append(&record, &bottom));
    EMA_ASSERT_STATUS(EMA_OK, ema_record_append(&record, &zero));
    EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&record, 0U, 1U, &read));
    EMA_ASSERT_CLOSE(3.0, read.channel[EMA_CHANNEL_POSITION], 0.0, 4.0 * EMA_EPS);
    EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&record, 1U, 1U, &read));
    EMA_ASSERT_CLOSE(-30.0, read.channel[EMA_CHANNEL_VOLTAGE], 0.0, 4.0 * EMA_EPS);
    EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&record, 2U, 1U, &read));
    TEST_ASSERT_TRUE((read.command_mm == EMA_R(0.0)) && (read.channel[EMA_CHANNEL_CURRENT] == EMA_R(0.0)));
}

static void test_the_ends_of_the_largest_and_smallest_full_scale_come_back_finite(void)
{
    const ema_real ends[2] = {EMA_R(1.0e-30), EMA_R(1.0e30)};
    for (uint32_t k = 0; k < 2U; ++k) {
        use_int16();
        config.command_full_scale_mm = ends[k];
        config.full_scale[EMA_CHANNEL_POSITION] = ends[k];
        start();
        ema_sample_t read;
        const ema_sample_t sample = {record.unit[0] * EMA_R(32767.0), {-record.unit[1] * EMA_R(32767.0)}};
        EMA_ASSERT_STATUS(EMA_OK, ema_record_append(&record, &sample));
        EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&record, 0U, 1U, &read));
        EMA_ASSERT_CLOSE(ends[k], read.command_mm, 0.0, 4.0 * EMA_EPS);
        EMA_ASSERT_CLOSE(-ends[k], read.channel[EMA_CHANNEL_POSITION], 0.0, 4.0 * EMA_EPS);
    }
}

static void test_int16_takes_two_bytes_a_value(void)
{
    use_int16();
    config.keep[EMA_CHANNEL_MOTOR_POSITION] = false;
    config.keep[EMA_CHANNEL_CURRENT] = false;
    config.keep[EMA_CHANNEL_VOLTAGE] = false;
    config.buffer_bytes = EMA_RECORD_INT16_BYTES(10, 2);
    start();
    TEST_ASSERT_EQUAL_UINT32(10U, record.capacity);
    config.buffer_bytes -= 1U;
    start();
    TEST_ASSERT_EQUAL_UINT32(9U, record.capacity);
}

static void test_channels_that_are_not_kept_read_zero_and_take_no_room(void)
{
    config.keep[EMA_CHANNEL_MOTOR_POSITION] = false;
    config.keep[EMA_CHANNEL_VOLTAGE] = false;
    config.buffer_bytes = EMA_RECORD_REAL_BYTES(10, 3);
    start();
    TEST_ASSERT_EQUAL_UINT32(10U, record.capacity);
    const ema_sample_t sent = {EMA_R(1.0), {EMA_R(2.0), (ema_real)NAN, EMA_R(4.0), EMA_R(5.0)}};
    ema_sample_t read;
    /* what is not kept is not looked at either */
    EMA_ASSERT_STATUS(EMA_OK, ema_record_append(&record, &sent));
    EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&record, 0U, 1U, &read));
    TEST_ASSERT_TRUE((read.command_mm == EMA_R(1.0)) && (read.channel[EMA_CHANNEL_POSITION] == EMA_R(2.0)));
    TEST_ASSERT_TRUE((read.channel[EMA_CHANNEL_MOTOR_POSITION] == EMA_R(0.0))
                     && (read.channel[EMA_CHANNEL_CURRENT] == EMA_R(4.0)));
    TEST_ASSERT_TRUE(read.channel[EMA_CHANNEL_VOLTAGE] == EMA_R(0.0));
}

static void test_rod_position_is_kept_always(void)
{
    config.keep[EMA_CHANNEL_POSITION] = false;
    start();
    TEST_ASSERT_TRUE(record.place[EMA_CHANNEL_POSITION] >= 0);
}

static void test_command_that_is_a_function_takes_no_room(void)
{
    const ema_command_t command = ema_rig_chirp(EMA_R(4.0), EMA_R(10.0), EMA_R(5.0e-4));
    config = ema_rig_real_record(memory, EMA_RECORD_REAL_BYTES(10, 1), false);
    config.command = &command;
    start();
    TEST_ASSERT_EQUAL_UINT32(10U, record.capacity);
    const ema_sample_t sent = {(ema_real)NAN, {EMA_R(2.0)}};
    for (uint32_t row = 0; row < 10U; ++row) {
        EMA_ASSERT_STATUS(EMA_OK, ema_record_append(&record, &sent));
    }
    ema_sample_t read;
    EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&record, 7U, 2U, &read));
    TEST_ASSERT_TRUE(read.command_mm == ema_command_at(&command, 14U));
    TEST_ASSERT_TRUE(read.channel[EMA_CHANNEL_POSITION] == EMA_R(2.0));
}

/* Rows are counted in 32 bits, however large the buffer. Nothing is written before a row comes. */
static void test_capacity_ends_where_the_count_ends(void)
{
    const ema_command_t command = ema_rig_chirp(EMA_R(4.0), EMA_R(10.0), EMA_R(5.0e-4));
    config = ema_rig_real_record(memory, SIZE_MAX, false);
    use_int16();
    config.keep[EMA_CHANNEL_POSITION] = true;
    config.command = &command;
    start();
    TEST_ASSERT_EQUAL_UINT32((uint32_t)INT32_MAX, record.capacity);
}

static void test_init_needs_its_pointers(void)
{
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_record_init(NULL, &config));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_record_init(&record, NULL));
    config.buffer = NULL;
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_record_init(&record, &config));
}

static void assert_refused(unsigned line)
{
    (void)memset(&record, 0x5A, sizeof record);
    const ema_record_t before = record;
    ema_assert_status(EMA_ERR_RANGE, ema_record_init(&record, &config), line);
    ema_assert_same_bits(&before, &record, sizeof before, line);
}

static void test_init_refuses_a_buffer_without_room_for_a_row(void)
{
    config.buffer_bytes = (5U * sizeof(ema_real)) - 1U;
    assert_refused(__LINE__);
    config.buffer_bytes = 0U;
    assert_refused(__LINE__);
    config.buffer_bytes = 5U * sizeof(ema_real);
    start();
}

static void test_init_refuses_a_full_scale_that_is_none(void)
{
    /* of 1e-42's counts no number is left: a sample of zero would be nothing over nothing; the largest float's counts
     * together round to infinity */
    const ema_real bad[6] = {EMA_R(0.0),         EMA_R(-1.0),    (ema_real)NAN,
                             (ema_real)INFINITY, EMA_R(1.0e-42), (ema_real)FLT_MAX};
    for (uint32_t k = 0; k < 6U; ++k) {
        use_int16();
        config.command_full_scale_mm = bad[k];
        assert_refused(__LINE__);
        for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
            use_int16();
            config.full_scale[channel] = bad[k];
            assert_refused(__LINE__);
        }
    }
}

static void test_full_scales_that_are_not_needed_are_not_looked_at(void)
{
    const ema_command_t command = ema_rig_chirp(EMA_R(4.0), EMA_R(10.0), EMA_R(1.0e-3));
    config.full_scale[EMA_CHANNEL_CURRENT] = EMA_R(-1.0);
    start();
    use_int16();
    config.keep[EMA_CHANNEL_CURRENT] = false;
    config.full_scale[EMA_CHANNEL_CURRENT] = EMA_R(-1.0);
    config.command = &command;
    config.command_full_scale_mm = EMA_R(-1.0);
    start();
}

/* A refused row must leave record and buffer as they were. */
static void assert_append_refused(ema_status_t expected, const ema_sample_t* sample, unsigned line)
{
    ema_real kept[5U * ROWS];
    (void)memcpy(kept, memory, sizeof memory);
    const ema_record_t before = record;
    ema_assert_status(expected, ema_record_append(&record, sample), line);
    ema_assert_same_bits(&before, &record, sizeof before, line);
    ema_assert_same_bits(kept, memory, sizeof memory, line);
}

static void test_init_refuses_a_buffer_that_is_not_aligned(void)
{
    config.buffer = (char*)memory + 1;
    config.buffer_bytes = sizeof memory - sizeof memory[0];
    for (uint32_t format = 0; format < 2U; ++format) {
        if (format == 1U) {
            use_int16();
        }
        (void)memset(&record, 0x5A, sizeof record);
        const ema_record_t before = record;
        EMA_ASSERT_STATUS(EMA_ERR_ALIGN, ema_record_init(&record, &config));
        EMA_ASSERT_SAME_BITS(&before, &record, sizeof before);
    }
    config.buffer = (char*)memory + 2;
    start();
}

/* Appended row by row, then the same bytes taken as they lie, in three parts. */
static void adopt_equals_append(void)
{
    start();
    for (uint32_t row = 0; row < ROWS; ++row) {
        const ema_sample_t sample = random_sample();
        EMA_ASSERT_STATUS(EMA_OK, ema_record_append(&record, &sample));
    }
    const ema_record_t appended = record;
    ema_real kept[5U * ROWS];
    (void)memcpy(kept, memory, sizeof memory);
    start();
    EMA_ASSERT_STATUS(EMA_OK, ema_record_adopt(&record, 0U));
    EMA_ASSERT_STATUS(EMA_OK, ema_record_adopt(&record, 1U));
    EMA_ASSERT_STATUS(EMA_OK, ema_record_adopt(&record, 7U));
    EMA_ASSERT_STATUS(EMA_OK, ema_record_adopt(&record, ROWS - 8U));
    EMA_ASSERT_SAME_BITS(&appended, &record, sizeof record);
    EMA_ASSERT_SAME_BITS(kept, memory, sizeof memory);
}

static void test_rows_that_lie_there_are_those_that_were_appended(void)
{
    adopt_equals_append();
    use_int16();
    config.buffer_bytes = EMA_RECORD_INT16_BYTES(ROWS, 5U);
    adopt_equals_append();
    const ema_command_t command = ema_rig_chirp(EMA_R(4.0), EMA_R(10.0), EMA_R(1.0e-3));
    config.command = &command;
    config.buffer_bytes = EMA_RECORD_INT16_BYTES(ROWS, 4U);
    adopt_equals_append();
}

static void assert_adopt_refused(ema_status_t expected, uint32_t rows, unsigned line)
{
    const ema_record_t before = record;
    ema_assert_status(expected, ema_record_adopt(&record, rows), line);
    ema_assert_same_bits(&before, &record, sizeof before, line);
}

static void test_adopt_refuses_what_append_refuses(void)
{
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_record_adopt(NULL, 1U));
    start();
    assert_adopt_refused(EMA_ERR_FULL, ROWS + 1U, __LINE__);
    EMA_ASSERT_STATUS(EMA_OK, ema_record_adopt(&record, 10U));
    assert_adopt_refused(EMA_ERR_FULL, ROWS - 9U, __LINE__);
    assert_adopt_refused(EMA_ERR_FULL, UINT32_MAX, __LINE__);
    memory[(5U * 12U) + 3U] = (ema_real)NAN;
    assert_adopt_refused(EMA_ERR_NOT_FINITE, 3U, __LINE__);
    EMA_ASSERT_STATUS(EMA_OK, ema_record_adopt(&record, 2U));
    /* every count is a number */
    use_int16();
    start();
    (void)memset(memory, 0x80, sizeof memory);
    EMA_ASSERT_STATUS(EMA_OK, ema_record_adopt(&record, ROWS));
    ema_sample_t sample;
    EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&record, ROWS - 1U, 1U, &sample));
    EMA_ASSERT_CLOSE(2.5 * -32640.0 / 32767.0, sample.command_mm, 0.0, 1.0e-5);
}

static void test_append_needs_its_pointers(void)
{
    const ema_sample_t sample = random_sample();
    start();
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_record_append(NULL, &sample));
    assert_append_refused(EMA_ERR_NULL, NULL, __LINE__);
}

static void test_append_refuses_a_row_too_many(void)
{
    const ema_sample_t sample = random_sample();
    start();
    for (uint32_t row = 0; row < ROWS; ++row) {
        EMA_ASSERT_STATUS(EMA_OK, ema_record_append(&record, &sample));
    }
    assert_append_refused(EMA_ERR_FULL, &sample, __LINE__);
}

static void test_append_refuses_what_is_not_finite(void)
{
    const ema_real bad[3] = {(ema_real)NAN, (ema_real)INFINITY, (ema_real)-INFINITY};
    for (uint32_t format = 0; format < 2U; ++format) {
        if (format == 1U) {
            use_int16();
        }
        start();
        for (uint32_t k = 0; k < 3U; ++k) {
            ema_sample_t sample = random_sample();
            sample.command_mm = bad[k];
            assert_append_refused(EMA_ERR_NOT_FINITE, &sample, __LINE__);
            for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
                sample = random_sample();
                sample.channel[channel] = bad[k];
                assert_append_refused(EMA_ERR_NOT_FINITE, &sample, __LINE__);
            }
        }
    }
}

static void test_append_refuses_what_exceeds_its_scale(void)
{
    use_int16();
    start();
    ema_sample_t sample = random_sample();
    sample.command_mm = EMA_R(-2.501);
    assert_append_refused(EMA_ERR_SCALE, &sample, __LINE__);
    const ema_real beyond[EMA_CHANNEL_COUNT] = {EMA_R(3.001), EMA_R(-4.001), EMA_R(25.01), EMA_R(-30.01)};
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        sample = random_sample();
        sample.channel[channel] = beyond[channel];
        assert_append_refused(EMA_ERR_SCALE, &sample, __LINE__);
    }
}

static void test_reals_have_no_scale(void)
{
    start();
    const ema_sample_t sample = {EMA_R(1.0e20), {EMA_R(-1.0e20), EMA_R(1.0e20), EMA_R(1.0e20), EMA_R(1.0e20)}};
    EMA_ASSERT_STATUS(EMA_OK, ema_record_append(&record, &sample));
}

static void test_read_needs_its_pointers(void)
{
    ema_sample_t sample = random_sample();
    start();
    EMA_ASSERT_STATUS(EMA_OK, ema_record_append(&record, &sample));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_record_read(NULL, 0U, 1U, &sample));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_record_read(&record, 0U, 1U, NULL));
}

static void test_read_refuses_a_row_that_is_not_there(void)
{
    ema_sample_t sample = random_sample();
    start();
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_record_read(&record, 0U, 1U, &sample));
    EMA_ASSERT_STATUS(EMA_OK, ema_record_append(&record, &sample));
    EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&record, 0U, 1U, &sample));
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_record_read(&record, 1U, 1U, &sample));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_reals_come_back_exactly);
    RUN_TEST(test_int16_comes_back_within_half_a_count);
    RUN_TEST(test_int16_keeps_full_scale_on_both_sides_and_zero);
    RUN_TEST(test_the_ends_of_the_largest_and_smallest_full_scale_come_back_finite);
    RUN_TEST(test_int16_takes_two_bytes_a_value);
    RUN_TEST(test_channels_that_are_not_kept_read_zero_and_take_no_room);
    RUN_TEST(test_rod_position_is_kept_always);
    RUN_TEST(test_command_that_is_a_function_takes_no_room);
    RUN_TEST(test_capacity_ends_where_the_count_ends);
    RUN_TEST(test_init_needs_its_pointers);
    RUN_TEST(test_init_refuses_a_buffer_without_room_for_a_row);
    RUN_TEST(test_init_refuses_a_full_scale_that_is_none);
    RUN_TEST(test_full_scales_that_are_not_needed_are_not_looked_at);
    RUN_TEST(test_init_refuses_a_buffer_that_is_not_aligned);
    RUN_TEST(test_rows_that_lie_there_are_those_that_were_appended);
    RUN_TEST(test_adopt_refuses_what_append_refuses);
    RUN_TEST(test_append_needs_its_pointers);
    RUN_TEST(test_append_refuses_a_row_too_many);
    RUN_TEST(test_append_refuses_what_is_not_finite);
    RUN_TEST(test_append_refuses_what_exceeds_its_scale);
    RUN_TEST(test_reals_have_no_scale);
    RUN_TEST(test_read_needs_its_pointers);
    RUN_TEST(test_read_refuses_a_row_that_is_not_there);
    return UNITY_END();
}
