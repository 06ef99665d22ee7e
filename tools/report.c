/* report.c - a message is put together in a fixed buffer and written at once.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/report.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void report(place where, const char *format, ...)
{
    char line[2048]; /* longer messages are cut: this must work when memory is gone */
    size_t room = sizeof line - 1, n = 0;

#define APPEND(...)                                                                                                    \
    do {                                                                                                               \
        int wrote = snprintf(line + n, room - n, __VA_ARGS__);                                                         \
        if (wrote > 0) n += (size_t)wrote < room - n ? (size_t)wrote : room - n - 1;                                   \
    } while (0)

    APPEND("epatch: ");
    if (where.file) {
        APPEND("%.1000s:", where.file);
        if (where.line) APPEND("%zu:", where.line);
        if (where.line && where.column) APPEND("%zu:", where.column);
        APPEND(" ");
    }
    va_list list;
    va_start(list, format);
    int wrote = vsnprintf(line + n, room - n, format, list);
    va_end(list);
    if (wrote > 0) n += (size_t)wrote < room - n ? (size_t)wrote : room - n - 1;
#undef APPEND

    for (size_t i = 0; i < n; ++i)
        if ((unsigned char)line[i] < 32 || line[i] == 127) line[i] = '?';
    line[n++] = '\n';
    fflush(stdout);
    fwrite(line, 1, n, stderr);
}
