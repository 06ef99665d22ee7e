/* files.h - whole files in, finished files out.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_FILES_H
#define EPATCH_FILES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/* How messages call a file: "<stdin>" for "-", else the path itself. */
const char *input_name(const char *path);

/* Everything in `path` ("-": standard input) in one malloc'ed block, followed by a 0 byte that `size` does not
 * count. Memory is bounded by what can be read, not by what the file system promises. NULL after a message. */
char *input_read(const char *path, size_t *size);

/* A file that appears under its name only when it is complete.
 *
 *     output o;
 *     if (!output_open(&o, path)) return 1;
 *     fwrite(..., o.file);                     or: write to o.name by other means
 *     if (failed) return output_discard(&o), 1;
 *     return output_close(&o) ? 0 : 1;
 *
 * o.name has the extension of `path`. "-" is standard output; devices and pipes are written in place. Write errors
 * need no checks on the way: output_close finds them. A signal that ends the program removes the file. */
typedef struct output {
    const char *path; /* as given                                             */
    char *target;     /* where it will stand, symbolic links resolved          */
    char *name;       /* what to write to: a new name beside target, or target */
    FILE *file;
} output;

/* False after a message. */
bool output_open(output *o, const char *path);
/* Flushes, checks, renames. False after a message; then nothing is left behind. */
bool output_close(output *o);
/* Removes what was written. */
void output_discard(output *o);

#endif
