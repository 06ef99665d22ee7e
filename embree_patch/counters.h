/* counters.h - what tracing costs, counted without locks or atomic additions.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Each thread adds to a cache line of its own, so counting is three ordinary additions. Threads get their line in the
 * order they first trace; lines are reused after EP_COUNTER_LINES threads, when two that run at once might lose counts.
 */
#ifndef EP_COUNTERS_H
#define EP_COUNTERS_H

#include "embree_patch/embree_patch.h"

#include <stdalign.h>

enum { EP_COUNTER_LINES = 1024 };

typedef struct ep_counter_line {
    alignas(64) EPCounters c;
} ep_counter_line;

extern _Thread_local EPCounters *ep_thread_line __attribute__((tls_model("initial-exec")));
EPCounters *ep_new_line(void);

static inline EPCounters *ep_counters(void)
{
    return ep_thread_line ? ep_thread_line : ep_new_line();
}

#endif
