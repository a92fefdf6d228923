/* Which effect the model lacks, told onboard by one simulation and one sum of products per effect.
 *
 * The ground test is always the same, so what each effect makes of its record is known beforehand: `ema export
 * --signatures` writes it as a constant table. One run of the known machine gives the residual, row by row; it is
 * averaged in bins, the healthy machine's own residual is taken off, and each row of the table is multiplied with it.
 * The table has been freed of what scatters and of CSJ and BLK, so that neither is named as an effect. Optional:
 * without a table nothing here is linked. How the table is made, and what it names: docs/ONBOARD_DIAGNOSIS.md.
 *
 *     ema_onboard_start(&onboard, &EMA_SIGNATURES, &EMA_ACTUATOR, &record, start_mm);
 *     while (!ema_onboard_done(&onboard)) { ema_onboard_run(&onboard, 200); }              in slices
 *     ema_onboard_result(&onboard, &finding);
 *
 * A guarded session does this itself: ema_guarded.h.
 */
#ifndef EMA_ONBOARD_H
#define EMA_ONBOARD_H

#include "ema/ema_model.h"
#include "ema/ema_record.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Version of the table's layout. */
#define EMA_SIGNATURES_VERSION 1U

/* Rows of a table: sets the memory. */
#define EMA_SIGNATURE_ROWS_MAX 112U

/* CSJ and BLK. */
#define EMA_SIGNATURE_FAULTS_MAX 2U

/* One effect in one shape: one row of the table, or two for an effect of unknown phase. Patterns of one effect follow
 * each other. */
typedef struct {
    uint8_t effect;   /* an ema_effect_id_t */
    uint8_t first;    /* its first row */
    uint8_t rows;     /* 1 or 2 */
    bool one_sided;   /* a negative product does not mean the effect */
    ema_real turn[3]; /* products to sizes: size = turn[0] p0 + turn[1] p1, and turn[2] p1 a quarter period apart */
    ema_real penalty; /* what the choice among the effect's shapes explains of pure noise */
} ema_pattern_t;

/* CSJ or BLK: its row and what it was when the table was made. */
typedef struct {
    ema_value_id_t id;
    uint8_t row;
    ema_real healthy;
    ema_real turn;   /* product to change of the value */
    ema_real length; /* of what a change of one makes of the whitened signals */
} ema_signature_fault_t;

/* Written by `ema export`: constant, in flash. A bin of `value` holds the command's mean, the healthy machine's
 * residual of each channel, then each row's channels. */
typedef struct {
    uint32_t version;
    uint32_t fingerprint; /* ema_onboard_fingerprint of the actuator */
    uint32_t record_rows;
    uint32_t bin_rows; /* rows of the record whose mean is taken */
    uint32_t bins;
    uint32_t channels;
    uint8_t channel[EMA_CHANNEL_COUNT]; /* which these are, by ema_channel_t */
    uint32_t patterns;
    uint32_t faults;
    uint32_t nuisances;                    /* rows of what scatters, in front of the others */
    uint32_t rows;                         /* in all */
    ema_real command_unit_mm;              /* of one count */
    ema_real command_apart_mm;             /* farther off it is another command */
    ema_real reference[EMA_CHANNEL_COUNT]; /* of one count, by place in `channel` */
    ema_real weight[EMA_CHANNEL_COUNT];    /* one over the noise of a bin's mean */
    ema_real limit;                        /* largest score of a machine without a missing effect */
    ema_real energy;                       /* largest squared residual of such a machine */
    ema_signature_fault_t fault[EMA_SIGNATURE_FAULTS_MAX];
    const ema_pattern_t* pattern;
    const ema_real* unit; /* of one count of each row */
    const int16_t* value;
} ema_signatures_t;

typedef enum {
    EMA_FINDING_ADEQUATE = 0, /* nothing above what healthy runs of this machine show */
    EMA_FINDING_MISSING = 1,  /* `effect`, or one of those that look alike */
    EMA_FINDING_UNKNOWN = 2,  /* something is missing, and the best effect leaves more than half of it */
    EMA_FINDING_NONE = 3      /* the record runs another command than the table, or the model left the finite numbers:
                                 nothing can be said */
} ema_finding_kind_t;

typedef struct {
    ema_finding_kind_t kind;
    ema_effect_id_t effect;    /* best; EMA_EFFECT_COUNT when none fits at all */
    ema_effect_id_t runner_up; /* the best of the others */
    ema_effect_set_t alike;    /* effects whose scores are too near to the best to be told from it, itself among them */
    ema_real score;            /* by how much the best lowers the squared residual, in variances of the noise */
    ema_real runner_up_score;
    ema_real limit;  /* the table's, wider where CSJ and BLK have moved far */
    ema_real size;   /* of the best: the change of the effect's first value; an amplitude where the phase is unknown. A
                        limit of the current has its share of what was measured */
    ema_real energy; /* squared residual after what scatters */
    ema_real
        moved[EMA_SIGNATURE_FAULTS_MAX]; /* change of CSJ and BLK that the residual asks for beyond the known machine */
} ema_finding_t;

/* Sums of products so far: a plain value. */
typedef struct {
    const ema_signatures_t* table;
    ema_real product[EMA_SIGNATURE_ROWS_MAX];
    ema_real difference[EMA_CHANNEL_COUNT]; /* measured minus simulated, summed over the bin */
    ema_real command_mm;                    /* summed over the bin */
    ema_real command_apart_mm;              /* largest distance of a bin's command from the table's */
    ema_real square;                        /* of the residual */
    ema_real moved_square;                  /* squared length of what CSJ and BLK had moved */
    uint32_t bin;
    uint32_t row_in_bin;
} ema_scores_t;

/* One run of the known machine beside a record. A copy is a checkpoint; the record's address is read at every call, so
 * a copy may be given another place of it. */
typedef struct {
    ema_cursor_t cursor;
    ema_scores_t scores;
    ema_model_t model;
} ema_onboard_t;

/* Checksum of an actuator's numbers in float32, CSJ and BLK left out. Cost: four multiplications per value. */
uint32_t ema_onboard_fingerprint(const ema_actuator_t* actuator);

/* Whether the table serves this actuator and record. Errors: EMA_ERR_NULL; EMA_ERR_TABLE for another version or
 * actuator, or one that is not as ema export writes it; EMA_ERR_RANGE for a channel that the record does not keep.
 * Cost: that of the checksum. */
ema_status_t ema_onboard_check(const ema_signatures_t* table, const ema_actuator_t* actuator,
                               const ema_record_t* record);

/* Prepares the run of `actuator`: the one that was exported, or with CSJ and BLK as identified. Errors: those of
 * ema_onboard_check and ema_model_init; the run is then not to be used. */
ema_status_t ema_onboard_start(ema_onboard_t* self, const ema_signatures_t* table, const ema_actuator_t* actuator,
                               const ema_record_t* record, ema_real start_mm);

/* Runs for `steps` plain steps of work (ema_objective_run); returns how many model steps it made, 0 once it is done.
 * Cost: that work, and one product per row and channel of the table at every end of a bin. */
uint32_t ema_onboard_run(ema_onboard_t* self, uint32_t steps);

bool ema_onboard_done(const ema_onboard_t* self);

/* What the sums say, after the run is done. Errors: EMA_ERR_NULL; EMA_ERR_ORDER before. Cost: a handful of operations
 * per pattern. */
ema_status_t ema_onboard_result(const ema_onboard_t* self, ema_finding_t* finding);

/* Name of an effect as the desk writes it; "none" for any other number. Cost: constant. */
const char* ema_effect_name(ema_effect_id_t effect);

#ifdef __cplusplus
}
#endif

#endif
