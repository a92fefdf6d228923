// The module from C++11: every header of it.
#include "ema/ema_actuator.h"
#include "ema/ema_annealer.h"
#include "ema/ema_annealer_check.h"
#include "ema/ema_command.h"
#include "ema/ema_cursor.h"
#include "ema/ema_damped.h"
#include "ema/ema_guarded.h"
#include "ema/ema_image.h"
#include "ema/ema_least_squares.h"
#include "ema/ema_model.h"
#include "ema/ema_objective.h"
#include "ema/ema_onboard.h"
#include "ema/ema_plant.h"
#include "ema/ema_random.h"
#include "ema/ema_real.h"
#include "ema/ema_record.h"
#include "ema/ema_schema.h"
#include "ema/ema_selftest.h"
#include "ema/ema_sensitivity.h"
#include "ema/ema_session.h"
#include "ema/ema_status.h"
#include "ema/ema_telemetry.h"
#include "ema/ema_trend.h"
#include "ema/ema_version.h"
#include "ema/ema_work.h"

int main()
{
    static ema_actuator_t actuator;
    return (ema_actuator_defaults(&actuator) == EMA_OK) ? 0 : 1;
}
