/* What the module asks of <math.h>; the compiler makes one instruction of each. */
#ifndef EMA_WASM_MATH_H
#define EMA_WASM_MATH_H

float fabsf(float x);
float sqrtf(float x);

#endif
