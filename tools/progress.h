/* progress.h - a bar on standard error while a person watches; nothing when it is not a terminal.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 *     progress p;
 *     progress_begin(&p, "render", tiles);
 *     ... from any thread: progress_add(&p, 1);
 *     progress_end(&p);                       wipes the bar */
#ifndef EPATCH_PROGRESS_H
#define EPATCH_PROGRESS_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>

typedef struct progress {
    const char *label;
    size_t total;
    double started;
    bool shown; /* standard error is a terminal */
    atomic_size_t done;
    atomic_ullong next; /* when to draw again, in ms after the start */
} progress;

void progress_begin(progress *p, const char *label, size_t total);
void progress_add(progress *p, size_t count);
void progress_end(progress *p);

/* Seconds on a clock that only goes forward. */
double wall_seconds(void);

#endif
