#include "session/ema_temperature_correction.h"

#include "base/ema_math.h"

/* What a rise over the mean of both values, which is a logarithm within 1 % up to 40 %, makes in degC: copper gains
 * 0.393 % a degree (IEC 60028), a grease loses about 2.8 %. */
#define EMA_WINDING_DEGC EMA_R(254.5)
#define EMA_GREASE_DEGC EMA_R(-35.7)

/* CSJ beside a winding and a grease that are so many degrees warmer than in the healthy runs, brought to the
 * temperature of those. Where they do not agree, one of them is changed by something else: the day is what lies between
 * the two nearest to the healthy runs, and what that makes of CSJ, as on any day, stays open. */
static void ema_temperature_correct_csj(const ema_params_t* params, ema_real winding_degC, ema_real grease_degC,
                                        ema_estimate_t* csj)
{
    const ema_real apart_degC = winding_degC - grease_degC;
    ema_real warmer_degC = grease_degC + (params->day_winding_ratio * apart_degC);
    ema_real moved_percent = params->csj_per_degC_percent * warmer_degC;
    ema_real scatter_percent = params->csj_day_scatter_percent;
    ema_real open_percent = EMA_R(0.0);
    if (!(ema_abs(apart_degC) < params->day_apart_degC)) {
        warmer_degC = ema_clamp(EMA_R(0.0), ema_min(winding_degC, grease_degC), ema_max(winding_degC, grease_degC));
        open_percent = params->csj_per_degC_percent * warmer_degC;
        moved_percent = EMA_R(0.0);
        scatter_percent = params->csj_scatter_percent;
    }
    const ema_real unsure_percent = params->csj_per_degC_std_percent * warmer_degC;
    csj->scatter_percent = ema_sqrt((scatter_percent * scatter_percent) + (unsure_percent * unsure_percent)
                                    + (open_percent * open_percent));
    const ema_real share = moved_percent / (EMA_R(100.0) + moved_percent);
    csj->estimate -= share * csj->estimate;
    csj->shift_percent -= share * (EMA_R(100.0) + csj->shift_percent);
}

void ema_temperature_correction(const ema_session_config_t* config, ema_result_t* result)
{
    const ema_params_t* const params = &config->actuator->params;
    ema_real winding_degC = EMA_R(0.0);
    ema_real grease_degC = EMA_R(0.0);
    uint32_t told = 0U;
    /* the day's values stand behind the faults */
    for (uint32_t i = config->identified_count; i > 0U; --i) {
        const ema_value_id_t id = config->identified[i - 1U].id;
        ema_estimate_t* const estimate = &result->identified[i - 1U];
        const ema_real rise = estimate->shift_percent / (EMA_R(100.0) + (EMA_R(0.5) * estimate->shift_percent));
        if (id == EMA_VALUE_ID(resistance_ohm)) {
            winding_degC = EMA_WINDING_DEGC * rise;
            ++told;
        } else if (id == EMA_VALUE_ID(viscous_Nm_s_per_rad)) {
            grease_degC = EMA_GREASE_DEGC * rise;
            ++told;
        } else if (id == EMA_VALUE_ID(blk_mm)) {
            estimate->scatter_percent = params->blk_scatter_percent;
        } else if (id == EMA_VALUE_ID(csj_Nm)) {
            estimate->scatter_percent = params->csj_scatter_percent;
            if ((params->day_apart_degC > EMA_R(0.0)) && (told == 2U)) {
                ema_temperature_correct_csj(params, winding_degC, grease_degC, estimate);
            }
        } else {
            /* scatters by nothing that the actuator says */
        }
    }
}
