/* Number of the lists ema_params.def and ema_effects.def: names, kinds and order of all that makes an actuator.
 *
 * A configuration carries the number of the lists that it was made for. One for others is refused, a header when it is
 * compiled and an image when it is opened, and is to be exported again. It is the beginning of the lists' SHA-256,
 * written here by the build's target `written` and held by a test; where lists differ, as with effects of one's own,
 * CMake defines it.
 */
#ifndef EMA_SCHEMA_H
#define EMA_SCHEMA_H

#ifndef EMA_CONFIG_SCHEMA
#ifdef EMA_OWN_EFFECTS
#error "EMA_OWN_EFFECTS lengthens the lists: build with CMake, or define EMA_CONFIG_SCHEMA as CMake prints it."
#endif
#define EMA_CONFIG_SCHEMA 0x54d1750eU
#endif

#endif
