/* json_place.c - walks valid JSON without building anything.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/json_place.h"

#include <jansson.h>

#include <stdbool.h>
#include <string.h>

static const char *skip_space(const char *s)
{
    return s + strspn(s, " \t\r\n");
}

/* s is at the opening quote; returns what follows the closing one. */
static const char *skip_string(const char *s)
{
    for (++s; *s && *s != '"'; ++s)
        if (*s == '\\' && s[1]) ++s;
    return *s ? s + 1 : s;
}

static const char *skip_value(const char *s)
{
    size_t depth = 0;
    do {
        s = skip_space(s);
        if (*s == '"') {
            s = skip_string(s);
        } else if (*s == '{' || *s == '[') {
            ++depth, ++s;
        } else if (*s == '}' || *s == ']') {
            --depth, ++s;
        } else if (*s == ',' || *s == ':') {
            ++s;
        } else {
            s += strcspn(s, " \t\r\n,:]}");
        }
    } while (depth && *s);
    return s;
}

/* Whether the string at s (quotes included) spells `key`, escapes resolved. */
static bool spells(const char *s, const char *key)
{
    json_t *word = json_loadb(s, (size_t)(skip_string(s) - s), JSON_DECODE_ANY, NULL);
    bool same = word && !strcmp(json_string_value(word), key);
    json_decref(word);
    return same;
}

/* The value at the end of the chain, or NULL; *key is where its key begins, if it has one. */
static const char *find(const char *text, const json_step *at, const char **key)
{
    if (!at->up) return skip_space(text);

    const char *s = find(text, at->up, key);
    if (!s || *s != (at->key ? '{' : '[')) return NULL;
    for (size_t i = 0; *s != '}' && *s != ']'; ++i) {
        s = skip_space(s + 1);
        if (at->key && *s == '"') {
            const char *value = skip_space(skip_space(skip_string(s)) + 1);
            if (spells(s, at->key)) return *key = s, value;
            s = value;
        } else if (!at->key && i == at->index && *s != ']') {
            return s;
        }
        if (*s == '}' || *s == ']' || !*s) return NULL;
        s = skip_space(skip_value(s));
    }
    return NULL;
}

place text_place(const char *file, const char *text, const char *at)
{
    place where = {file, 1, 1};
    for (const char *c = text; c < at; ++c) {
        if (*c == '\n') {
            ++where.line;
            where.column = 1;
        } else if ((*c & 0xC0) != 0x80) {
            ++where.column;
        }
    }
    return where;
}

place json_place(const char *file, const char *text, const json_step *at, int at_key)
{
    const char *key = NULL, *s = find(text, at, &key);
    if (!s) return (place){file, 0, 0};
    return text_place(file, text, at_key ? key : s);
}
