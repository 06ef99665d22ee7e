/* obj_text.h - words and numbers of Wavefront OBJ files.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A statement is a line; a backslash at its end lets it go on in the next. Functions that read return false after a
 * message; `what` names in it what is not there. */
#ifndef EPATCH_OBJ_TEXT_H
#define EPATCH_OBJ_TEXT_H

#include "tools/json_place.h"

#include <stdbool.h>
#include <stddef.h>

typedef struct obj_word {
    const char *at;
    size_t length;
} obj_word;

typedef struct obj_text {
    const char *path, *begin;
    const char *at;      /* what comes next */
    obj_word statement;  /* the name of the one that is read */
    obj_word word;       /* the last one that was read */
    obj_word ignored[8]; /* names of what is not known; more are not told of */
    size_t ignored_count;
} obj_text;

/* For a message about what stands at `at`. */
place obj_place(const obj_text *t, const char *at);

/* For %.*s: a word, or what there is room for. */
#define OBJ_SHOWN(word) (int)((word).length < 30 ? (word).length : 30), (word).at

bool obj_is(obj_word w, const char *name);

/* To the next statement that is not empty, and behind its name. False at the end of the file, without a message. */
bool obj_next_statement(obj_text *t);
bool obj_skip_statement(obj_text *t); /* always true */

/* Remembers the name of what is skipped, once. */
void obj_ignore(obj_text *t, obj_word name);
/* A line to standard error for each. */
void obj_report_ignored(const obj_text *t);

/* Behind blanks and a comment: is that the end of the statement? */
bool obj_at_end(obj_text *t);

bool obj_next_word(obj_text *t, const char *what);
bool obj_read_number(obj_text *t, const char *what, double *to);

/* A reference to one of `count` items above, which count from 1 or, with a minus sign, back from the last one; as an
 * index. What may follow behind slashes, of a vertex its texture and normal, is passed over. */
bool obj_read_reference(obj_text *t, const char *what, const char *item, size_t count, size_t *to);

/* Says that the last word is not `what`. Always false. */
bool obj_wrong_word(const obj_text *t, const char *what);

/* True without a problem, else tells of it. */
bool obj_is_fine(const obj_text *t, const char *at, const char *problem);

/* Behind the whole number at s, or s itself when there is none. */
const char *obj_whole_end(const char *s);

#endif
