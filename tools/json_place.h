/* json_place.h - the line and column of a value in a JSON text.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * jansson keeps no positions. A reader that walks the parsed tree carries a chain of steps, one on the stack for
 * each level; only when something is wrong is the text walked along that chain. */
#ifndef EPATCH_JSON_PLACE_H
#define EPATCH_JSON_PLACE_H

#include "tools/report.h"

#include <stddef.h>

/* One step from the root to a value: a member of an object (key) or an element of an array (key NULL, index). The root
 * itself is a step whose `up` is NULL. */
typedef struct json_step {
    const struct json_step *up;
    const char *key;
    size_t index;
} json_step;

/* Where the value at the end of the chain begins; with `at_key`, where its key does. `text` is valid JSON, closed by a
 * 0 byte. Of the file alone when the chain leads nowhere. */
place json_place(const char *file, const char *text, const json_step *at, int at_key);

/* Where the character `at` of a text is. */
place text_place(const char *file, const char *text, const char *at);

#endif
