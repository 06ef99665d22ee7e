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
