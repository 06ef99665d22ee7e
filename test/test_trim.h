/* test_trim.h - what the tests of trim/ share: random regions, described twice.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef TEST_TRIM_H
#define TEST_TRIM_H

#include "trim/trim.h"
#include "test/oracle/rng.h"
#include "test/oracle/trim_reference.h"

/* cmocka wants these before itself */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

/* Prints what the arguments say and where, and fails the test. */
#define FAIL(...) (print_error("%s:%d: ", __FILE__, __LINE__), print_error(__VA_ARGS__), print_error("\n"), fail())
#define CHECK(condition, ...)                                                                                          \
    do {                                                                                                               \
        if (!(condition)) FAIL(#condition ": " __VA_ARGS__);                                                           \
    } while (0)

/* How coordinates and weights are drawn. */
typedef struct trim_style {
    double grid; /* coordinates are multiples of it; 0: anything */
    double most_weight;
    unsigned most_degree;
} trim_style;

enum { RANDOM_POINTS = 16 };

/* A tree of operators of that depth over random contours about the unit square. */
trim_shape *random_shape(rng *r, unsigned depth, trim_style style);

/* The same region for trim/. */
EPStatus build_shape(ep_region *region, const trim_shape *s, ep_message *m);
/* A trim of it; fails the test otherwise. Prepares the shape, too. */
ep_trim *new_trim(trim_shape *s);

#endif
