/* obj_text.c - see obj_text.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/obj_text.h"
#include "tools/args.h"
#include "tools/report.h"

#include <stdlib.h>
#include <string.h>

place obj_place(const obj_text *t, const char *at)
{
    return text_place(t->path, t->begin, at);
}

/* The length of the end of line that a backslash hides, else 0. */
static size_t continued(const char *at)
{
    if (*at != '\\') return 0;
    return at[1] == '\n' ? 2 : at[1] == '\r' && at[2] == '\n' ? 3 : 0;
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\v' || c == '\f' || c == '\r';
}

/* To the next word, or to the end of the statement. A comment has no next line. */
static void skip_blanks(obj_text *t)
{
    for (;;) {
        size_t more = continued(t->at);
        if (more) t->at += more;
        else if (is_blank(*t->at)) ++t->at;
        else break;
    }
    if (*t->at == '#') t->at += strcspn(t->at, "\n");
}

bool obj_at_end(obj_text *t)
{
    skip_blanks(t);
    return !*t->at || *t->at == '\n';
}

/* The word that stands here. */
static obj_word this_word(const obj_text *t)
{
    const char *end = t->at;
    while (*end && *end != '\n' && !is_blank(*end) && !continued(end)) ++end;
    return (obj_word){t->at, (size_t)(end - t->at)};
}

bool obj_is(obj_word w, const char *name)
{
    return w.length == strlen(name) && !memcmp(w.at, name, w.length);
}

bool obj_next_word(obj_text *t, const char *what)
{
    if (obj_at_end(t)) return report(obj_place(t, t->at), "the line ends before %s", what), false;
    t->word = this_word(t);
    t->at += t->word.length;
    return true;
}

bool obj_wrong_word(const obj_text *t, const char *what)
{
    report(obj_place(t, t->word.at), "'%.*s' is not %s", OBJ_SHOWN(t->word), what);
    return false;
}

bool obj_is_fine(const obj_text *t, const char *at, const char *problem)
{
    if (problem) report(obj_place(t, at), "%s", problem);
    return !problem;
}

bool obj_skip_statement(obj_text *t)
{
    while (!obj_at_end(t)) t->at += this_word(t).length;
    return true;
}

bool obj_next_statement(obj_text *t)
{
    while (obj_at_end(t) && *t->at) ++t->at;
    t->statement = t->word = this_word(t);
    t->at += t->word.length;
    return t->word.length;
}

bool obj_read_number(obj_text *t, const char *what, double *to)
{
    if (!obj_next_word(t, what)) return false;
    char *end;
    *to = strtod(t->word.at, &end);
    return end == t->word.at + t->word.length || obj_wrong_word(t, what);
}

const char *obj_whole_end(const char *s)
{
    const char *digits = s + (*s == '+' || *s == '-'), *end = digits + strspn(digits, "0123456789");
    return end == digits ? s : end;
}

bool obj_read_reference(obj_text *t, const char *what, const char *item, size_t count, size_t *to)
{
    if (!obj_next_word(t, what)) return false;
    const obj_word w = t->word;
    const char *number_end = obj_whole_end(w.at), *end = number_end;
    for (int i = 0; i < 2 && *end == '/'; ++i) end = obj_whole_end(end + 1);
    if (number_end == w.at || end != w.at + w.length) return obj_wrong_word(t, what);

    const long long have = (long long)count;
    const long long n = strtoll(w.at, NULL, 10); /* the nearest there is when it is too large */
    if (n && n <= have && n >= -have) return *to = (size_t)(n > 0 ? n - 1 : have + n), true;
    const obj_word number = {w.at, (size_t)(number_end - w.at)};
    report(obj_place(t, w.at), "there is no %s %.*s: %lld are defined above", item, OBJ_SHOWN(number), have);
    return false;
}

void obj_ignore(obj_text *t, obj_word name)
{
    for (size_t i = 0; i < t->ignored_count; ++i)
        if (t->ignored[i].length == name.length && !memcmp(t->ignored[i].at, name.at, name.length)) return;
    if (t->ignored_count < ARG_COUNT(t->ignored)) t->ignored[t->ignored_count++] = name;
}

void obj_report_ignored(const obj_text *t)
{
    for (size_t i = 0; i < t->ignored_count; ++i)
        report(obj_place(t, t->ignored[i].at), "'%.*s' is not known and ignored", OBJ_SHOWN(t->ignored[i]));
}
