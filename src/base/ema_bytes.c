#include "base/ema_bytes.h"

uint32_t ema_crc32(uint32_t crc, const uint8_t* bytes, size_t length)
{
    /* four bits at a time: a table of 64 bytes */
    static const uint32_t table[16] = {0x00000000U, 0x1DB71064U, 0x3B6E20C8U, 0x26D930ACU, 0x76DC4190U, 0x6B6B51F4U,
                                       0x4DB26158U, 0x5005713CU, 0xEDB88320U, 0xF00F9344U, 0xD6D6A3E8U, 0xCB61B38CU,
                                       0x9B64C2B0U, 0x86D3D2D4U, 0xA00AE278U, 0xBDBDF21CU};
    uint32_t found = ~crc;
    for (size_t k = 0; k < length; ++k) {
        found ^= (uint32_t)bytes[k];
        found = (found >> 4) ^ table[found & 15U];
        found = (found >> 4) ^ table[found & 15U];
    }
    return ~found;
}
