/* json_walk.c - see json_walk.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/json_walk.h"
#include "tools/args.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool vwrong(const json_reader *r, const json_node *n, bool at_key, const char *format, va_list list)
{
    char message[400];
    vsnprintf(message, sizeof message, format, list);
    report(json_place(r->name, r->text, &n->at, at_key), "%s", message);
    return false;
}

bool json_wrong(const json_reader *r, const json_node *n, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    vwrong(r, n, false, format, list);
    va_end(list);
    return false;
}

bool json_wrong_key(const json_reader *r, const json_node *n, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    vwrong(r, n, true, format, list);
    va_end(list);
    return false;
}

bool json_no_memory(const json_reader *r)
{
    report_no_memory(r->name);
    return false;
}

json_node json_member(const json_node *object, const char *key)
{
    return (json_node){{&object->at, key, 0}, json_object_get(object->json, key)};
}

json_node json_element(const json_node *array, size_t i)
{
    return (json_node){{&array->at, NULL, i}, json_array_get(array->json, i)};
}

static const char *type_name(json_type type)
{
    switch (type) {
    case JSON_OBJECT: return "an object";
    case JSON_ARRAY: return "an array";
    case JSON_STRING: return "a string";
    case JSON_INTEGER:
    case JSON_REAL: return "a number";
    case JSON_TRUE:
    case JSON_FALSE: return "true or false";
    case JSON_NULL: break;
    }
    return "null";
}

/* `what` names the value in messages: "the camera's eye". */
bool json_is(const json_reader *r, const json_node *n, json_type type, const char *what)
{
    if (json_typeof(n->json) == type) return true;
    return json_wrong(r, n, "%s is %s, not %s", what, type_name(json_typeof(n->json)), type_name(type));
}

bool json_only_keys(const json_reader *r, const json_node *object, const char *what, const char *const *keys,
                    size_t count)
{
    const char *key;
    json_t *value;
    json_object_foreach(object->json, key, value)
    {
        size_t i = 0;
        while (i < count && strcmp(key, keys[i])) ++i;
        if (i < count) continue;
        json_node n = json_member(object, key);
        const char *nearest = args_nearest(key, keys, count);
        if (nearest) return json_wrong_key(r, &n, "%s has no key '%s'; did you mean '%s'?", what, key, nearest);
        return json_wrong_key(r, &n, "%s has no key '%s'", what, key);
    }
    return true;
}

bool json_read_number(const json_reader *r, const json_node *n, const char *what, double *to)
{
    if (!json_is_number(n->json))
        return json_wrong(r, n, "%s is %s, not a number", what, type_name(json_typeof(n->json)));
    *to = json_number_value(n->json);
    return true;
}

bool json_read_whole(const json_reader *r, const json_node *n, const char *what, double least, double most, double *to)
{
    if (!json_read_number(r, n, what, to)) return false;
    if (*to >= least && *to <= most && *to == floor(*to)) return true;
    return json_wrong(r, n, "%s is %.10g, not a whole number from %.10g to %.10g", what, *to, least, most);
}

bool json_read_index(const json_reader *r, const json_node *n, const char *what, size_t count, uint32_t *to)
{
    double x = 0;
    if (!count) return json_wrong(r, n, "there are no %s", what);
    char name[40];
    snprintf(name, sizeof name, "an index into %s", what);
    if (!json_read_whole(r, n, name, 0, fmin((double)(count - 1), UINT32_MAX), &x)) return false;
    *to = (uint32_t)x;
    return true;
}

bool json_read_numbers(const json_reader *r, const json_node *n, const char *what, size_t count, double *to)
{
    if (!json_is(r, n, JSON_ARRAY, what)) return false;
    if (json_array_size(n->json) != count)
        return json_wrong(r, n, "%s has %zu numbers, not %zu", what, json_array_size(n->json), count);
    for (size_t i = 0; i < count; ++i) {
        json_node e = json_element(n, i);
        if (!json_read_number(r, &e, what, &to[i])) return false;
    }
    return true;
}

double *json_read_list(const json_reader *r, const json_node *n, const char *what, size_t *count)
{
    if (!json_is(r, n, JSON_ARRAY, what)) return NULL;
    *count = json_array_size(n->json);
    double *list = malloc((*count + 1) * sizeof *list);
    if (!list) return json_no_memory(r), NULL;
    if (json_read_numbers(r, n, what, *count, list)) return list;
    free(list);
    return NULL;
}

bool json_read_string(const json_reader *r, const json_node *n, const char *what, char **to)
{
    if (!json_is(r, n, JSON_STRING, what)) return false;
    *to = strdup(json_string_value(n->json));
    return *to || json_no_memory(r);
}
