/* counters.c - see counters.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/counters.h"

#include <stdatomic.h>

static ep_counter_line lines[EP_COUNTER_LINES];
static atomic_uint used;

_Thread_local EPCounters *ep_thread_line __attribute__((tls_model("initial-exec")));

EPCounters *ep_new_line(void)
{
    ep_thread_line = &lines[atomic_fetch_add(&used, 1) % EP_COUNTER_LINES].c;
    return ep_thread_line;
}

void epGetThreadCounters(EPCounters *counters)
{
    *counters = *ep_counters();
}

void epGetCounters(EPCounters *counters)
{
    *counters = (EPCounters){0};
    for (int i = 0; i < EP_COUNTER_LINES; ++i) {
        counters->visits += lines[i].c.visits;
        counters->solves += lines[i].c.solves;
        counters->evaluations += lines[i].c.evaluations;
        counters->cells += lines[i].c.cells;
        counters->slow += lines[i].c.slow;
    }
}
