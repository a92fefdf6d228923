/* A binary image of configurations, as `ema export --image` writes it: its source is written from the file by
 * tests/target/make_image.py. On a board of your own it may as well lie at an address that the linker script names. */
#ifndef ACE_IMAGE_H
#define ACE_IMAGE_H

#include <stddef.h>
#include <stdint.h>

extern const uint8_t ace_image[];
extern const size_t ace_image_bytes;

#endif
