/* bench_figure.c - a number that was measured several times.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void bench_add(bench_figure *f, double value)
{
    f->run[f->runs++] = value;
}

static int compare(const void *x, const void *y)
{
    double a = *(const double *)x, b = *(const double *)y;
    return (a > b) - (a < b);
}

double bench_median(const bench_figure *f)
{
    double sorted[BENCH_RUNS_MAX];
    if (!f->runs) return 0;
    memcpy(sorted, f->run, f->runs * sizeof *sorted);
    qsort(sorted, f->runs, sizeof *sorted, compare);
    return 0.5 * (sorted[(f->runs - 1) / 2] + sorted[f->runs / 2]);
}

double bench_least(const bench_figure *f)
{
    double x = f->runs ? f->run[0] : 0;
    for (unsigned i = 1; i < f->runs; ++i) x = fmin(x, f->run[i]);
    return x;
}

double bench_most(const bench_figure *f)
{
    double x = f->runs ? f->run[0] : 0;
    for (unsigned i = 1; i < f->runs; ++i) x = fmax(x, f->run[i]);
    return x;
}
