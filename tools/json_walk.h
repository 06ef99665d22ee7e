/* json_walk.h - walking a parsed JSON text and saying where something in it is wrong.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A node is a value with the way to it from the root, so that a message can name line and column (json_place.h). Each
 * level of the walk keeps its node on the stack. Functions that return bool return false after a message. */
#ifndef EPATCH_JSON_WALK_H
#define EPATCH_JSON_WALK_H

#include "tools/json_place.h"

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

typedef struct json_reader {
    const char *path, *text;
    const char *name; /* of the file in messages */
} json_reader;

typedef struct json_node {
    json_step at; /* first, so that a child's `up` leads here */
    json_t *json; /* NULL: not there */
} json_node;

json_node json_member(const json_node *object, const char *key);
json_node json_element(const json_node *array, size_t i);

/* Say that the value, or its key, is wrong. Always false. */
bool json_wrong(const json_reader *r, const json_node *n, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
bool json_wrong_key(const json_reader *r, const json_node *n, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
bool json_no_memory(const json_reader *r);

/* `what` names the value in messages: "the camera's eye". */
bool json_is(const json_reader *r, const json_node *n, json_type type, const char *what);
bool json_only_keys(const json_reader *r, const json_node *object, const char *what, const char *const *keys,
                    size_t count);
bool json_read_number(const json_reader *r, const json_node *n, const char *what, double *to);
bool json_read_whole(const json_reader *r, const json_node *n, const char *what, double least, double most, double *to);
/* `what` of which there are `count`. */
bool json_read_index(const json_reader *r, const json_node *n, const char *what, size_t count, uint32_t *to);
bool json_read_numbers(const json_reader *r, const json_node *n, const char *what, size_t count, double *to);
/* A list of any length, malloc'ed; NULL after a message. */
double *json_read_list(const json_reader *r, const json_node *n, const char *what, size_t *count);
bool json_read_string(const json_reader *r, const json_node *n, const char *what, char **to);

#endif
