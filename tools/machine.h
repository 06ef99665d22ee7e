/* machine.h - what a measurement was made on.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_MACHINE_H
#define EPATCH_MACHINE_H

#include <stddef.h>

typedef struct machine {
    char cpu[80]; /* "unknown" where nobody says */
    char compiler[80];
    char embree[32]; /* "3.13.5" */
    unsigned cores;  /* that are online */
    const char *isa; /* the best of the library's instruction sets that runs here */
} machine;

machine machine_describe(void);

/* Bytes that programs could have without the machine starting to swap, within this process's own limit. */
size_t machine_free_memory(void);

#endif
