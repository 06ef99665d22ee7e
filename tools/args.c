/* args.c - one loop over argv; one function a kind of value; the help printed from the same table.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/args.h"
#include "tools/report.h"

#include "embree_patch/embree_patch.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Longer words are nobody's misspelling of ours. */
#define WORD_MAX 40

static const char *const common_names[] = {"--help", "--version"};

static int command_length(const arg_table *table)
{
    return (int)strcspn(table->usage, " ");
}

int args_wrong(const arg_table *table, const char *format, ...)
{
    char message[400];
    va_list list;
    va_start(list, format);
    vsnprintf(message, sizeof message, format, list);
    va_end(list);

    int n = command_length(table);
    report((place){0}, "%.*s: %s (see epatch %.*s --help)", n, table->usage, message, n, table->usage);
    return 2;
}

/* Levenshtein's distance, where swapping two neighbours costs one as well. */
static unsigned distance(const char *a, const char *b)
{
    unsigned row[3][WORD_MAX + 1];
    size_t na = strlen(a), nb = strlen(b);

    for (size_t j = 0; j <= nb; ++j) row[0][j] = (unsigned)j;
    for (size_t i = 1; i <= na; ++i) {
        unsigned *now = row[i % 3], *last = row[(i + 2) % 3], *before = row[(i + 1) % 3];
        now[0] = (unsigned)i;
        for (size_t j = 1; j <= nb; ++j) {
            unsigned best = last[j - 1] + (a[i - 1] != b[j - 1]);
            if (last[j] + 1 < best) best = last[j] + 1;
            if (now[j - 1] + 1 < best) best = now[j - 1] + 1;
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] && before[j - 2] + 1 < best)
                best = before[j - 2] + 1;
            now[j] = best;
        }
    }
    return row[na % 3][nb];
}

const char *args_nearest(const char *word, const char *const *words, size_t count)
{
    const char *nearest = NULL;
    size_t length = strlen(word);
    unsigned best = 1 + (unsigned)length / 4; /* more slips than that make another word */

    if (length > WORD_MAX) return NULL;
    for (size_t i = 0; i < count; ++i) {
        if (strlen(words[i]) > WORD_MAX) continue;
        unsigned d = distance(word, words[i]);
        if (d <= best && (!nearest || d < best)) best = d, nearest = words[i];
    }
    return nearest;
}

/* "--output" of "-o, --output". */
static const char *long_name(const arg_option *o)
{
    return strncmp(o->name, "--", 2) ? o->name + 4 : o->name;
}

static const arg_option *find(const arg_table *table, const char *name, size_t length)
{
    for (size_t i = 0; i < table->option_count; ++i) {
        const arg_option *o = &table->options[i];
        const char *full = long_name(o);
        if (strlen(full) == length && !memcmp(full, name, length)) return o;
        if (full != o->name && length == 2 && !memcmp(o->name, name, 2)) return o;
    }
    return NULL;
}

static int unknown(const arg_table *table, const char *name, size_t length)
{
    char word[WORD_MAX + 1];
    const char *names[64], *nearest = NULL;
    size_t count = 0;

    for (size_t i = 0; i < table->option_count && count < 60; ++i) names[count++] = long_name(&table->options[i]);
    for (size_t i = 0; i < ARG_COUNT(common_names); ++i) names[count++] = common_names[i];
    if (length <= WORD_MAX) {
        memcpy(word, name, length);
        word[length] = 0;
        nearest = args_nearest(word, names, count);
    }
    if (nearest) return args_wrong(table, "unknown option '%.*s'; did you mean '%s'?", (int)length, name, nearest);
    return args_wrong(table, "unknown option '%.*s'", (int)length, name);
}

/* Index of the word text[0..length) in a list such as "a|b|c", or -1. */
static int word_index(const char *list, char separator, const char *text, size_t length)
{
    const char ends[] = {separator, 0};
    for (int i = 0;; ++i) {
        size_t n = strcspn(list, ends);
        if (n == length && !memcmp(list, text, n)) return i;
        if (!list[n]) return -1;
        list += n + 1;
    }
}

static bool read_unsigned(const char **at, double most, unsigned *to)
{
    char *end;
    if (**at < '0' || **at > '9') return false;
    errno = 0;
    unsigned long x = strtoul(*at, &end, 10);
    if (errno || (double)x > most) return false;
    *to = (unsigned)x;
    *at = end;
    return true;
}

static bool read_double(const char **at, double *to)
{
    char *end;
    double x = strtod(*at, &end);
    if (end == *at || !isfinite(x)) return false;
    *to = x;
    *at = end;
    return true;
}

static int set_value(const arg_table *table, const arg_option *o, const char *text)
{
    const char *name = long_name(o), *at = text;

    switch (o->kind) {
    case ARG_KIND_FLAG: *o->to.flag = true; return ARGS_GO;
    case ARG_KIND_STRING:
        if (!*text) return args_wrong(table, "%s is empty", name);
        *o->to.string = text;
        return ARGS_GO;
    case ARG_KIND_UNSIGNED: {
        unsigned x;
        if (!read_unsigned(&at, o->most, &x) || *at || x < o->least)
            return args_wrong(table, "%s is '%s', not a whole number from %.0f to %.0f", name, text, o->least, o->most);
        *o->to.whole = x;
        return ARGS_GO;
    }
    case ARG_KIND_DOUBLE: {
        double x;
        if (!read_double(&at, &x) || *at || x < o->least || x > o->most)
            return args_wrong(table, "%s is '%s', not a number from %g to %g", name, text, o->least, o->most);
        *o->to.real = x;
        return ARGS_GO;
    }
    case ARG_KIND_CHOICE: {
        int i = word_index(o->value, '|', text, strlen(text));
        if (i < 0) return args_wrong(table, "%s is '%s', not one of %s", name, text, o->value);
        *o->to.whole = (unsigned)i;
        return ARGS_GO;
    }
    case ARG_KIND_CHOICE_N: {
        size_t first = strcspn(o->value, "|"), second = strcspn(o->value + first + 1, "N"); /* as in "triangles:" */
        unsigned n = 0;
        bool known = strlen(text) == first && !memcmp(text, o->value, first);
        if (!strncmp(text, o->value + first + 1, second)) {
            at += second;
            known = read_unsigned(&at, o->most, &n) && !*at && n >= o->least;
        }
        if (!known)
            return args_wrong(table, "%s is '%s', not %.*s or %s with N from %.0f to %.0f", name, text, (int)first,
                              o->value, o->value + first + 1, o->least, o->most);
        *o->to.whole = n;
        return ARGS_GO;
    }
    case ARG_KIND_SET: {
        unsigned set = 0;
        for (;; ++at) {
            size_t n = strcspn(at, ",");
            int i = word_index(o->value, ',', at, n);
            if (i < 0) return args_wrong(table, "%s has '%.*s', which is not one of %s", name, (int)n, at, o->value);
            set |= 1u << i;
            at += n;
            if (!*at) break;
        }
        *o->to.whole = set;
        return ARGS_GO;
    }
    case ARG_KIND_SIZE: {
        unsigned w, h;
        bool ok = read_unsigned(&at, o->most, &w) && *at++ == 'x' && read_unsigned(&at, o->most, &h) && !*at;
        if (!ok || w < o->least || h < o->least)
            return args_wrong(table, "%s is '%s', not WxH with both from %.0f to %.0f", name, text, o->least, o->most);
        o->to.whole[0] = w;
        o->to.whole[1] = h;
        return ARGS_GO;
    }
    case ARG_KIND_DOUBLES: {
        double x;
        for (size_t i = 0; i < o->count; ++i, ++at) /* first see that all are there, then store */
            if (!read_double(&at, &x) || *at != (i + 1 < o->count ? ',' : 0))
                return args_wrong(table, "%s is '%s', not %zu numbers separated by commas", name, text, o->count);
        at = text;
        for (size_t i = 0; i < o->count; ++i, ++at) read_double(&at, &o->to.real[i]);
        return ARGS_GO;
    }
    }
    return ARGS_GO;
}

static void print_option(const char *name, const char *value, const char *help)
{
    char head[120];
    bool letter = strncmp(name, "--", 2) != 0;
    int n = snprintf(head, sizeof head, "%s%s%s%s", letter ? "" : "    ", name, value ? " " : "", value ? value : "");
    printf(n <= 30 ? "  %-30s  " : "  %s\n                                  ", head);
    for (; *help; ++help) {
        putchar(*help);
        if (*help == '\n') fputs("                                  ", stdout);
    }
    putchar('\n');
}

static void print_help(const arg_table *table)
{
    printf("usage: epatch %s [options]\n\n%s\n\noptions:\n", table->usage, table->summary);
    for (size_t i = 0; i < table->option_count; ++i) {
        const arg_option *o = &table->options[i];
        print_option(o->name, o->value, o->help);
    }
    print_option("--help", NULL, "this text");
    print_option("--version", NULL, "the version");
}

int args_parse(const arg_table *table, int argc, char **argv)
{
    bool options = true, given = false;

    for (int i = 1; i < argc; ++i) {
        const char *a = argv[i];
        if (!options || a[0] != '-' || !a[1]) {
            if (!table->operand) return args_wrong(table, "'%s' is too much", a);
            if (given) return args_wrong(table, "'%s' is too much after %s '%s'", a, table->operand, *table->to);
            *table->to = a;
            given = true;
            continue;
        }
        if (!strcmp(a, "--")) {
            options = false;
            continue;
        }
        if (!strcmp(a, "--help") || !strcmp(a, "-h")) return print_help(table), 0;
        if (!strcmp(a, "--version")) return puts("epatch " EP_VERSION_STRING), 0;

        size_t length = strcspn(a, "=");
        const arg_option *o = find(table, a, length);
        if (!o) return unknown(table, a, length);

        const char *value = a[length] ? a + length + 1 : NULL;
        if (o->kind == ARG_KIND_FLAG && value) return args_wrong(table, "%s takes no value", long_name(o));
        if (o->kind != ARG_KIND_FLAG && !value) {
            if (++i == argc) return args_wrong(table, "%s needs a value: %s", long_name(o), o->value);
            value = argv[i];
        }
        int status = set_value(table, o, value);
        if (status != ARGS_GO) return status;
    }
    if (table->operand && !given) return args_wrong(table, "%s is missing", table->operand);
    if (given && !**table->to) return args_wrong(table, "%s is empty", table->operand);
    return ARGS_GO;
}
