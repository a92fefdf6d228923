/* The whole public interface of the module: firmware includes this file alone.
 *
 * The contracts, each in a header of its own: ema_actuator.h (parameters, ranges, optional effects), ema_command.h
 * (ground-test commands), ema_record.h (recorded samples), ema_model.h (simulation), ema_session.h (identification and
 * verdict in four calls), ema_guarded.h (the same with a table of signatures), ema_least_squares.h (a search for up to
 * eight values), ema_image.h (configurations in flash), ema_telemetry.h (results as bytes), ema_trend.h (trend and
 * remaining life), ema_selftest.h (power-on self-test). Headers in ema/detail/ hold what these need because structures
 * nest by value; they are not included by hand.
 */
#ifndef EMA_H
#define EMA_H

#include "ema/ema_actuator.h"
#include "ema/ema_command.h"
#include "ema/ema_guarded.h"
#include "ema/ema_image.h"
#include "ema/ema_least_squares.h"
#include "ema/ema_model.h"
#include "ema/ema_record.h"
#include "ema/ema_selftest.h"
#include "ema/ema_session.h"
#include "ema/ema_telemetry.h"
#include "ema/ema_trend.h"

#endif
