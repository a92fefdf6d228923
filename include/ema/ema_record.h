/* A recording in a buffer that the caller sizes: scaled 16-bit integers or reals, one row per recorded instant.
 *
 * The buffer belongs to the caller and must outlive the record. A row holds the command (unless the command is a
 * function of time) and the channels that the configuration names, in the order of ema_channel_t.
 */
#ifndef EMA_RECORD_H
#define EMA_RECORD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ema/detail/ema_real.h"
#include "ema/detail/ema_status.h"
#include "ema/ema_command.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    EMA_CHANNEL_POSITION = 0,       /* rod, mm; always recorded */
    EMA_CHANNEL_MOTOR_POSITION = 1, /* motor encoder expressed at the rod, mm */
    EMA_CHANNEL_CURRENT = 2,        /* A */
    EMA_CHANNEL_VOLTAGE = 3         /* V, applied from this instant on */
} ema_channel_t;

#define EMA_CHANNEL_COUNT 4U

/* One recorded instant. Channels that the record does not keep are not read. */
typedef struct {
    ema_real command_mm;
    ema_real channel[EMA_CHANNEL_COUNT]; /* mm, mm, A, V: by ema_channel_t */
} ema_sample_t;

typedef enum {
    EMA_RECORD_INT16 = 0, /* two bytes a value */
    EMA_RECORD_REAL = 1   /* one ema_real a value */
} ema_record_format_t;

typedef struct {
    void* buffer; /* aligned for what it holds, int16_t or ema_real */
    size_t buffer_bytes;
    ema_record_format_t format;
    const ema_command_t* command;   /* NULL: the command is recorded with the samples */
    bool keep[EMA_CHANNEL_COUNT];   /* further channels to keep; the rod position always is */
    ema_real command_full_scale_mm; /* int16: the largest value that can be kept */
    ema_real full_scale[EMA_CHANNEL_COUNT];
} ema_record_config_t;

typedef struct {
    void* buffer;
    const ema_command_t* command;
    uint32_t capacity; /* rows */
    uint32_t count;
    ema_real asked_mm; /* way that the recorded command has made */
    ema_record_format_t format;
    uint8_t stride;                        /* values a row */
    int8_t place[EMA_CHANNEL_COUNT];       /* of the channel in the row, -1 when it is not kept */
    ema_real unit[1U + EMA_CHANNEL_COUNT]; /* int16: value of one count, by place */
} ema_record_t;

/* Bytes of buffer for `rows` rows of `values` int16 values: command and rod position are two. */
#define EMA_RECORD_INT16_BYTES(rows, values) ((size_t)(rows) * (size_t)(values) * sizeof(int16_t))
#define EMA_RECORD_REAL_BYTES(rows, values) ((size_t)(rows) * (size_t)(values) * sizeof(ema_real))

/* Makes an empty record; what the buffer holds stays there. Errors: EMA_ERR_NULL; EMA_ERR_RANGE for a format that is
 * none, a full scale outside 1e-30..1e30, or a buffer without room for one row; EMA_ERR_ALIGN; EMA_ERR_ABSENT for a
 * format or a command that the build leaves out. */
ema_status_t ema_record_init(ema_record_t* record, const ema_record_config_t* config);

/* Adds a row. Errors, the record unchanged: EMA_ERR_NULL; EMA_ERR_FULL; EMA_ERR_NOT_FINITE; EMA_ERR_SCALE. Cost:
 * constant. */
ema_status_t ema_record_append(ema_record_t* record, const ema_sample_t* sample);

/* Takes `rows` rows that lie in the buffer already, behind those that the record has: raw counts that a DMA wrote
 * there, or reals, each row as the record keeps it (`stride` values: the command, unless it is a function, then the
 * channels that are kept). A count is worth full_scale / 32767. Whoever writes has finished, and made its writes seen
 * by the core that calls. Errors, the record unchanged: EMA_ERR_NULL; EMA_ERR_FULL for more rows than fit;
 * EMA_ERR_NOT_FINITE for a real that is none. Cost: one pass over the rows where the command is recorded, or reals are;
 * else constant. */
ema_status_t ema_record_adopt(ema_record_t* record, uint32_t rows);

/* Reads row `row`; channels that are not kept read zero. With a command that is a function, command_mm is its value at
 * model step row * every_steps. Errors: EMA_ERR_NULL; EMA_ERR_RANGE. Cost: constant. */
ema_status_t ema_record_read(const ema_record_t* record, uint32_t row, uint32_t every_steps, ema_sample_t* sample);

/* Where runs of a model stand beside a record.
 *
 * A plain structure: a copy is a checkpoint. The record's address is read at every step, so a copy may be given another
 * place of the same record.
 */
typedef struct {
    const ema_record_t* record;
    uint32_t every_steps; /* model steps between two rows */
    uint32_t rows;        /* after which the runs end */
    uint32_t row;
    uint32_t step_in_row; /* 0: the present model step shows the row */
} ema_cursor_t;

#ifdef __cplusplus
}
#endif

#endif
