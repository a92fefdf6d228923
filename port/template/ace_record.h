/* A recorded chirp, for ace_recorded.c: its source is written from a CSV file by tests/target/make_records.py. */
#ifndef ACE_RECORD_H
#define ACE_RECORD_H

#include <stdint.h>

/* Command and rod position in mm and current in A of every control tick, as bits of a float. */
extern const uint32_t ace_record[][3];
extern const uint32_t ace_record_rows;

#endif
