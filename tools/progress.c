/* progress.c - the bar is drawn ten times a second by whichever thread comes first.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/progress.h"

#include <stdio.h>
#include <time.h>
#include <unistd.h>

#define PERIOD_MS 100
#define BAR_CELLS 40

double wall_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void progress_begin(progress *p, const char *label, size_t total)
{
    p->label = label;
    p->total = total ? total : 1;
    p->started = wall_seconds();
    p->shown = isatty(STDERR_FILENO);
    atomic_init(&p->done, 0);
    atomic_init(&p->next, PERIOD_MS);
}

void progress_add(progress *p, size_t count)
{
    size_t done = atomic_fetch_add(&p->done, count) + count;
    if (!p->shown) return;

    double seconds = wall_seconds() - p->started;
    unsigned long long now = (unsigned long long)(1000 * seconds), due = atomic_load(&p->next);
    if (now < due || !atomic_compare_exchange_strong(&p->next, &due, now + PERIOD_MS)) return;

    double part = (double)done / (double)p->total;
    int cells = (int)(BAR_CELLS * part);
    char line[160];
    int n = snprintf(line, sizeof line, "\r%.20s [%.*s%*s] %3.0f %%  %.0f s left  ", p->label, cells,
                     "########################################", BAR_CELLS - cells, "", 100 * part,
                     seconds / part - seconds);
    fwrite(line, 1, (size_t)n, stderr);
}

void progress_end(progress *p)
{
    if (p->shown) fputs("\r\033[K", stderr);
}
