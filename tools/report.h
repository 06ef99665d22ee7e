/* report.h - the one place that writes messages: `epatch: FILE:LINE:COLUMN: what is wrong`.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_REPORT_H
#define EPATCH_REPORT_H

#include <stddef.h>

/* Where in a file something is wrong. Lines and columns count from 1 and columns count characters of UTF-8; 0 is
 * "unknown", and then is not printed. file NULL: no place at all. */
typedef struct place {
    const char *file;
    size_t line, column;
} place;

/* Prints one line to standard error: always one, whatever bytes the names in it hold. Never allocates. */
void report(place where, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The usual short forms. */
#define report_file(path, ...) report((place){path, 0, 0}, __VA_ARGS__)
#define report_no_memory(path) report((place){path, 0, 0}, "out of memory")

#endif
