/* table.h - a few rows of short texts, aligned for a terminal or as Markdown.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_TABLE_H
#define EPATCH_TABLE_H

#include <stdbool.h>
#include <stddef.h>

enum { TABLE_ROWS = 64, TABLE_COLUMNS = 16, TABLE_TEXT = 32 };

/* Starts from zeros. The first row is the head; the first cell of a row is its name. Texts that are too long are cut,
 * rows and cells that are too many are dropped. */
typedef struct table {
    char text[TABLE_ROWS][TABLE_COLUMNS][TABLE_TEXT];
    unsigned cells[TABLE_ROWS];
    bool apart[TABLE_ROWS]; /* an empty line before the row, on a terminal */
    unsigned rows;
} table;

void table_row(table *t);
/* The next cell of the last row. */
void table_cell(table *t, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* The same for a number, in three digits; a size; a time. */
void table_figure(table *t, double x);
void table_bytes(table *t, size_t bytes);
void table_seconds(table *t, double s);
void table_print(const table *t, bool markdown);

#endif
