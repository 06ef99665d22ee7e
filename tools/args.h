/* args.h - command lines, parsed and explained from one table.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 *     const char *scene = NULL, *image = NULL;
 *     unsigned size[2] = {1280, 720};
 *     const arg_option options[] = {
 *         ARG_STRING("-o, --output", "IMAGE", &image, "write the picture here"),
 *         ARG_SIZE("--size", "WxH", size, "pixels (1280x720)"),
 *     };
 *     const arg_table table = {"render SCENE -o IMAGE", "draws a scene", "SCENE", &scene, options, ARG_COUNT(options)};
 *     int status = args_parse(&table, argc, argv);
 *     if (status != ARGS_GO) return status;
 *     if (!image) return args_wrong(&table, "-o IMAGE is missing");
 *
 * `--name value`, `--name=value` and `-o value` are understood; `--` ends the options, a lone `-` is an operand or a
 * value. Destinations keep their defaults when the option is absent; given twice, the last one counts. --help and
 * --version are in every table. Destinations are typed: the compiler rejects ARG_DOUBLE into an unsigned. */
#ifndef EPATCH_ARGS_H
#define EPATCH_ARGS_H

#include <stdbool.h>
#include <stddef.h>

typedef enum arg_kind {
    ARG_KIND_FLAG,
    ARG_KIND_UNSIGNED,
    ARG_KIND_DOUBLE,
    ARG_KIND_STRING,
    ARG_KIND_CHOICE,
    ARG_KIND_CHOICE_N,
    ARG_KIND_SET,
    ARG_KIND_SIZE,
    ARG_KIND_DOUBLES
} arg_kind;

typedef struct arg_option {
    arg_kind kind;
    const char *name;  /* "--spp", or "-o, --output" where there is a letter too   */
    const char *value; /* how the help calls the value; the list of words for a choice or a set */
    const char *help;
    union {
        bool *flag;
        unsigned *whole;
        double *real;
        const char **string;
    } to;
    double least, most; /* of numbers, inclusive                  */
    size_t count;       /* how many numbers a list of doubles has */
} arg_option;

#define ARG_ROW(kind, name, value, to, least, most, count, help)                                                       \
    {                                                                                                                  \
        kind, name, value, help, {to}, least, most, count                                                              \
    }
/* Sets a bool to true. */
#define ARG_FLAG(name, to, help) ARG_ROW(ARG_KIND_FLAG, name, NULL, .flag = to, 0, 0, 0, help)
/* A whole number in [least, most]. */
#define ARG_UNSIGNED(name, value, to, least, most, help)                                                               \
    ARG_ROW(ARG_KIND_UNSIGNED, name, value, .whole = to, least, most, 0, help)
/* A finite number in [least, most]. */
#define ARG_DOUBLE(name, value, to, least, most, help)                                                                 \
    ARG_ROW(ARG_KIND_DOUBLE, name, value, .real = to, least, most, 0, help)
/* Anything but nothing; points into argv. */
#define ARG_STRING(name, value, to, help) ARG_ROW(ARG_KIND_STRING, name, value, .string = to, 0, 0, 0, help)
/* One word of `words`, such as "plain|avx2|avx512"; stores its index. */
#define ARG_CHOICE(name, words, to, help) ARG_ROW(ARG_KIND_CHOICE, name, words, .whole = to, 0, 0, 0, help)
/* `words` is such as "patches|triangles:N": stores 0 for the first word, N in [least, most] for the second. */
#define ARG_CHOICE_N(name, words, to, least, most, help)                                                               \
    ARG_ROW(ARG_KIND_CHOICE_N, name, words, .whole = to, least, most, 0, help)
/* A list such as depth,uv of words of `words`, such as "depth,normal,uv"; stores the sum of 1 << index. */
#define ARG_SET(name, words, to, help) ARG_ROW(ARG_KIND_SET, name, words, .whole = to, 0, 0, 0, help)
/* WxH into an array of two, each in 1..65536. */
#define ARG_SIZE(name, value, to, help) ARG_ROW(ARG_KIND_SIZE, name, value, .whole = to, 1, 65536, 2, help)
/* Exactly `count` finite numbers separated by commas. */
#define ARG_DOUBLES(name, value, to, count, help) ARG_ROW(ARG_KIND_DOUBLES, name, value, .real = to, 0, 0, count, help)

typedef struct arg_table {
    const char *usage;   /* "trace SCENE --rays FILE --hits FILE": the first word is the command's name */
    const char *summary; /* what it does; lines separated by \n                                         */
    const char *operand; /* how the one operand is called, or NULL when there is none                   */
    const char **to;     /* where it goes; the operand is required                                      */
    const arg_option *options;
    size_t option_count;
} arg_table;

#define ARG_COUNT(array) (sizeof(array) / sizeof *(array))

#define ARGS_GO (-1)

/* ARGS_GO, or the exit status to return at once: 0 after --help and --version, 2 after a message. */
int args_parse(const arg_table *table, int argc, char **argv);

/* Prints `epatch: trace: <message>` and where to find help, both on one line; returns 2. */
int args_wrong(const arg_table *table, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The word of words[0..count) that `word` may have been meant as, or NULL. */
const char *args_nearest(const char *word, const char *const *words, size_t count);

#endif
