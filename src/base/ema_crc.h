/* The checksum of Ethernet and zip files, CRC-32: it sees every error of one bit, and every one within 32 bits. */
#ifndef EMA_CRC_H
#define EMA_CRC_H

#include <stddef.h>
#include <stdint.h>

/* Of `length` bytes behind those whose checksum `crc` is; 0 before the first. Cost: some ten instructions a byte. */
uint32_t ema_crc32(uint32_t crc, const uint8_t* bytes, size_t length);

#endif
