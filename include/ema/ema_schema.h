/* Number of the lists ema_params.def and ema_effects.def: names, kinds and order of everything that makes an actuator.
 *
 * A configuration carries the number it was made for; one of other lists is refused, a header when it is compiled and
 * an image when it is opened, and is to be exported again. The number is a checksum of the lists, written by the
 * build's target `written` and held against them by a test.
 */
#ifndef EMA_SCHEMA_H
#define EMA_SCHEMA_H

/* Of the project's own lists. */
#define EMA_SCHEMA_SHIPPED 0x00000000U

/* Effects of one's own lengthen the structure; CMake defines their number. */
#ifdef EMA_OWN_EFFECTS
#ifndef EMA_OWN_SCHEMA
#error "EMA_OWN_EFFECTS changes the lists: define EMA_OWN_SCHEMA too, with the number that CMake prints for them."
#endif
#define EMA_CONFIG_SCHEMA (EMA_SCHEMA_SHIPPED ^ EMA_OWN_SCHEMA)
#else
#define EMA_CONFIG_SCHEMA EMA_SCHEMA_SHIPPED
#endif

#endif
