/* cad_child.c - cad_read of cad.h, done by a child process.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * OpenCASCADE prints what it likes and crashes on some broken files. There it does neither to this program, which reads
 * the faces from a pipe: what happened, then for a face its numbers, in the order of the structures that they belong
 * to. It comes with dozens of libraries, and is loaded when it is wanted. */
#include "tools/shim/cad.h"
#include "tools/shim/module.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

typedef struct event {
    enum { FACE, NO_FACE, END } kind;
    uint32_t index, total;
    char text[240]; /* what is wrong, if anything is */
} event;

/* The child's side. */

static void put(FILE *to, const void *data, size_t count, size_t size)
{
    if (fwrite(data, size, count, to) != count) _exit(1); /* nobody listens any more */
}

static void put_event(FILE *to, int kind, uint32_t index, uint32_t total, const char *text)
{
    event e = {.kind = kind, .index = index, .total = total};
    snprintf(e.text, sizeof e.text, "%s", text ? text : "");
    put(to, &e, 1, sizeof e);
}

static void put_curve(FILE *to, const cad_curve *c)
{
    put(to, c->knots, c->knot_count, sizeof *c->knots);
    put(to, c->points, c->count, sizeof *c->points);
}

static void put_loop(FILE *to, const cad_loop *l)
{
    put(to, l->curves, l->count, sizeof *l->curves);
    for (size_t i = 0; i < l->count; ++i) put_curve(to, &l->curves[i]);
}

static bool put_face(void *user, uint32_t index, uint32_t total, const cad_face *f, const char *problem)
{
    FILE *to = user;
    put_event(to, f ? FACE : NO_FACE, index, total, problem);
    if (!f) return true;
    put(to, f, 1, sizeof *f);
    for (int i = 0; i < 2; ++i) put(to, f->knots[i], f->knot_count[i], sizeof *f->knots[i]);
    put(to, f->points, f->count[0] * f->count[1], sizeof *f->points);
    put(to, f->loops, f->loop_count, sizeof *f->loops);
    for (size_t i = 0; i < f->loop_count; ++i) put_loop(to, &f->loops[i]);
    return true;
}

typedef const char *(*reader)(const char *path, cad_format format, cad_taker take, void *user);

/* Nobody else would end it where it hangs. */
static void die_with_parent(pid_t parent)
{
#ifdef __linux__
    prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
    if (getppid() != parent) _exit(1);
}

/* OpenCASCADE goes round in circles in some damaged files. Large ones take a second for a megabyte or two. */
static void limit_time(const char *path)
{
    enum { SECONDS = 60, SECONDS_A_MEGABYTE = 20 };
    struct stat file;
    const rlim_t size = stat(path, &file) == 0 ? (rlim_t)file.st_size : 0;
    const rlim_t seconds = SECONDS + SECONDS_A_MEGABYTE * (size >> 20);
    setrlimit(RLIMIT_CPU, &(struct rlimit){seconds, seconds + 1});
}

static void serve(reader read, const char *path, cad_format format, int pipe)
{
    limit_time(path);
    FILE *to = fdopen(pipe, "wb");
    const int nowhere = open("/dev/null", O_WRONLY);
    if (!to || nowhere < 0 || dup2(nowhere, STDOUT_FILENO) < 0 || dup2(nowhere, STDERR_FILENO) < 0) _exit(1);
    const char *problem = read(path, format, put_face, to);
    put_event(to, END, 0, 0, problem);
    _exit(fflush(to) ? 1 : 0);
}

/* The parent's side. */

typedef struct incoming {
    FILE *from;
    void **blocks; /* of the face */
    size_t count, capacity;
    bool no_memory;
} incoming;

/* NULL when there is no memory or no more. */
static void *get(incoming *in, size_t count, size_t size)
{
    if (in->count == in->capacity) {
        const size_t capacity = in->capacity ? 2 * in->capacity : 64;
        void **blocks = realloc(in->blocks, capacity * sizeof *blocks);
        if (!blocks) return in->no_memory = true, NULL;
        in->blocks = blocks;
        in->capacity = capacity;
    }
    void *block = calloc(count ? count : 1, size);
    if (!block) return in->no_memory = true, NULL;
    in->blocks[in->count++] = block;
    return fread(block, size, count, in->from) == count ? block : NULL;
}

static bool get_loop(incoming *in, cad_loop *l)
{
    cad_curve *c = get(in, l->count, sizeof *c);
    l->curves = c;
    for (size_t i = 0; c && i < l->count; ++i, ++c) {
        c->knots = get(in, c->knot_count, sizeof *c->knots);
        c->points = c->knots ? get(in, c->count, sizeof *c->points) : NULL;
        if (!c->points) return false;
    }
    return l->curves;
}

static const cad_face *get_face(incoming *in)
{
    cad_face *f = get(in, 1, sizeof *f);
    for (int i = 0; f && i < 2; ++i)
        if (!(f->knots[i] = get(in, f->knot_count[i], sizeof *f->knots[i]))) return NULL;
    if (!f || !(f->points = get(in, f->count[0] * f->count[1], sizeof *f->points))) return NULL;
    cad_loop *l = get(in, f->loop_count, sizeof *l);
    f->loops = l;
    for (size_t i = 0; l && i < f->loop_count; ++i)
        if (!get_loop(in, &l[i])) return NULL;
    return l ? f : NULL;
}

static void drop(incoming *in)
{
    while (in->count) free(in->blocks[--in->count]);
}

/* True when the child has come to its end, or `take` wants no more; then *e is what came last. */
static bool take_all(incoming *in, event *e, cad_taker take, void *user)
{
    while (fread(e, sizeof *e, 1, in->from) == 1) {
        if (e->kind == END) return true;
        const cad_face *f = e->kind == FACE ? get_face(in) : NULL;
        if (e->kind == FACE && !f) return false;
        const bool more = take(user, e->index, e->total, f, f ? NULL : e->text);
        drop(in);
        if (!more) return e->text[0] = 0, true;
    }
    return false;
}

const char *cad_read(const char *path, cad_format format, cad_taker take, void *user)
{
    static void *module;
    static _Thread_local char problem[sizeof((event *)0)->text];
    const reader read = (reader)module_function(&module, "epatch_cad.so", "cad_read");
    int ends[2];
    if (pipe(ends)) return strerror(errno);
    const pid_t parent = getpid(), child = fork();
    if (child == 0) {
        die_with_parent(parent);
        close(ends[0]);
        serve(read, path, format, ends[1]);
    }
    close(ends[1]);
    incoming in = {.from = child > 0 ? fdopen(ends[0], "rb") : NULL};
    event e = {.text = "out of memory"};
    const bool is_complete = in.from && take_all(&in, &e, take, user);
    drop(&in);
    free(in.blocks);
    if (in.from) fclose(in.from);
    else close(ends[0]);
    int status = 0;
    if (child > 0) {
        kill(child, SIGKILL); /* it may still have something to say, or be lost */
        waitpid(child, &status, 0);
    }
    const char *end = in.from && !in.no_memory ? "OpenCASCADE crashes on it" : "out of memory";
    if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) end = "OpenCASCADE comes to no end with it";
    snprintf(problem, sizeof problem, "%s", is_complete ? e.text : end);
    return problem[0] ? problem : NULL;
}
