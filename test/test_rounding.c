/* test_rounding.c - does the compiler round where the source does? meson.build has the flags that make it.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Bounds are made for the float that is stored, not for the double it was: a conversion to float and back must not be
 * lost, neither in loops of any length nor between neighbours in an array. */
#include "test/support.h"

#define NARROW(count)                                                                                                  \
    static __attribute__((noinline)) void narrow_##count(const double *from, float *narrow, double *back)              \
    {                                                                                                                  \
        for (int i = 0; i < count; ++i) narrow[i] = (float)from[i];                                                    \
        for (int i = 0; i < count; ++i) back[i] = narrow[i];                                                           \
    }                                                                                                                  \
    static __attribute__((noinline)) void rest_##count(const double *restrict from, double *restrict back)             \
    {                                                                                                                  \
        for (int i = 0; i < count; ++i) back[i] = (double)(float)from[i];                                              \
    }
NARROW(2)
NARROW(3)
NARROW(4)
NARROW(7)
NARROW(16)

static void check(int count, void (*narrow)(const double *, float *, double *), void (*rest)(const double *, double *))
{
    double from[16] = {0}, back[16];
    float narrowed[16];
    for (int i = 0; i < count; ++i) from[i] = 1 / (i + 3.1);
    narrow(from, narrowed, back);
    for (int i = 0; i < count; ++i) CHECK(back[i] == narrowed[i], "%d of %d was not rounded", i, count);
    rest(from, back);
    for (int i = 0; i < count; ++i) CHECK(back[i] == narrowed[i], "%d of %d was not rounded", i, count);
}

static void conversions_stay(void **state)
{
    (void)state;
    check(2, narrow_2, rest_2);
    check(3, narrow_3, rest_3);
    check(4, narrow_4, rest_4);
    check(7, narrow_7, rest_7);
    check(16, narrow_16, rest_16);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(conversions_stay)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
