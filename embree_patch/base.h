/* base.h - how to allocate, how to fail, how to round outwards.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_BASE_H
#define EP_BASE_H

#include "embree_patch/embree_patch.h"

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>

#define EP_ARRAY_LEN(a) (sizeof(a) / sizeof(a)[0])
#define EP_PRINTF(string, first) __attribute__((format(printf, string, first)))

/* 64-byte aligned memory, the alignment of a cache line and of the widest register; NULL when there is none. Sizes
 * are products of counts that come from outside, so the product is checked here. */
void *ep_alloc(size_t count, size_t size);
void ep_free(void *p);

/* Makes room for `more` items of `size` bytes behind the first `count` of *items, at least doubling *capacity. False,
 * and all as it was, when there is no memory. */
bool ep_reserve(void **items, size_t *capacity, size_t count, size_t more, size_t size);

/* Gives back the room behind the first `count`. False, and all as it was, when there is no memory. */
bool ep_shrink(void **items, size_t *capacity, size_t count, size_t size);

/* For tests: the n-th allocation from now fails, counting from 0; negative: none does. */
void ep_alloc_fail_at(long n);

/* The last failure in words. Cut to fit, never allocated: it must work out of memory. */
typedef struct ep_message {
    char text[256];
} ep_message;

EPStatus ep_fail(ep_message *m, EPStatus s, const char *format, ...) EP_PRINTF(3, 4);

/* The nearest float that is not below (above) x. NaN stays NaN. */
static inline float ep_round_up(double x)
{
    float f = (float)x;
    return (double)f < x ? nextafterf(f, INFINITY) : f;
}
static inline float ep_round_down(double x)
{
    return -ep_round_up(-x);
}

/* Half the distance from 1 to the next float: the relative error of one rounding. */
#define EP_EPS_F 0x1p-24
#define EP_EPS_D 0x1p-53

#endif
