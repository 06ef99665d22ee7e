/* table.c - names to the left, numbers to the right.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/table.h"

#include <stdarg.h>
#include <stdio.h>

void table_row(table *t)
{
    if (t->rows < TABLE_ROWS) ++t->rows;
}

void table_cell(table *t, const char *format, ...)
{
    const unsigned row = t->rows - 1;
    if (t->cells[row] == TABLE_COLUMNS) return;
    va_list list;
    va_start(list, format);
    vsnprintf(t->text[row][t->cells[row]++], TABLE_TEXT, format, list);
    va_end(list);
}

void table_figure(table *t, double x)
{
    table_cell(t, x < 0.0995 ? "%.3f" : x < 9.995 ? "%.2f" : x < 99.95 ? "%.1f" : "%.0f", x);
}

void table_bytes(table *t, size_t bytes)
{
    const double mb = (double)bytes / 1e6;
    if (mb < 0.1) table_cell(t, "%.1f kB", 1e3 * mb);
    else if (mb < 9.995) table_cell(t, "%.2f MB", mb);
    else if (mb < 9995) table_cell(t, "%.0f MB", mb);
    else table_cell(t, "%.1f GB", mb / 1e3);
}

void table_seconds(table *t, double s)
{
    if (s < 0.9995) table_cell(t, "%.*f ms", s < 0.00995 ? 1 : 0, 1e3 * s);
    else table_cell(t, "%.1f s", s);
}

static unsigned length(const char *utf8)
{
    unsigned n = 0;
    for (; *utf8; ++utf8) n += (*utf8 & 0xc0) != 0x80;
    return n;
}

static void print_row(const table *t, unsigned row, const unsigned *width, bool markdown)
{
    if (t->apart[row] && !markdown) putchar('\n');
    for (unsigned c = 0; c < t->cells[0]; ++c) {
        const char *text = t->text[row][c];
        const int blanks = (int)(width[c] - length(text));
        fputs(markdown ? c ? " | " : "| " : c ? "  " : "", stdout);
        if (c) printf("%*s%s", blanks, "", text);
        else printf("%s%*s", text, blanks, "");
    }
    puts(markdown ? " |" : "");
}

void table_print(const table *t, bool markdown)
{
    unsigned width[TABLE_COLUMNS] = {0};
    for (unsigned r = 0; r < t->rows; ++r)
        for (unsigned c = 0; c < t->cells[0]; ++c) {
            const unsigned n = length(t->text[r][c]);
            if (n > width[c]) width[c] = n;
        }
    for (unsigned r = 0; r < t->rows; ++r) {
        print_row(t, r, width, markdown);
        if (r || !markdown) continue;
        for (unsigned c = 0; c < t->cells[0]; ++c) fputs(c ? " ---: |" : "| --- |", stdout);
        putchar('\n');
    }
}
