/* files.c - reading whole, writing through a temporary name.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#define _XOPEN_SOURCE 700 /* realpath */
#include "tools/files.h"
#include "tools/report.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

const char *input_name(const char *path)
{
    return strcmp(path, "-") ? path : "<stdin>";
}

static char *read_all(FILE *file, const char *name, size_t *size)
{
    struct stat st;
    size_t capacity = 1 << 16, n = 0;
    /* A regular file is read in one piece; its size is no promise, only the first guess. */
    if (!fstat(fileno(file), &st) && S_ISREG(st.st_mode) && st.st_size > 0) capacity = (size_t)st.st_size + 2;

    char *data = malloc(capacity);
    while (data) {
        n += fread(data + n, 1, capacity - 1 - n, file);
        if (n < capacity - 1) break;
        char *more = capacity <= SIZE_MAX / 2 ? realloc(data, capacity *= 2) : NULL;
        if (!more) free(data);
        data = more;
    }
    if (!data) {
        report_no_memory(name);
        return NULL;
    }
    if (ferror(file)) {
        report_file(name, "cannot read: %s", strerror(errno));
        free(data);
        return NULL;
    }
    data[n] = 0;
    *size = n;
    return data;
}

char *input_read(const char *path, size_t *size)
{
    if (!strcmp(path, "-")) return read_all(stdin, input_name(path), size);

    FILE *file = fopen(path, "rb");
    if (!file) {
        report_file(path, "cannot open: %s", strerror(errno));
        return NULL;
    }
    errno = 0;
    char *data = read_all(file, path, size);
    fclose(file);
    return data;
}

/* Temporary names that exist now, for the signal handler. A command writes two files at most. */
static _Atomic(const char *) unfinished[4];

static void remember(const char *name)
{
    for (size_t i = 0; i < sizeof unfinished / sizeof *unfinished; ++i) {
        const char *none = NULL;
        if (atomic_compare_exchange_strong(&unfinished[i], &none, name)) return;
    }
}

static void forget(const char *name)
{
    for (size_t i = 0; i < sizeof unfinished / sizeof *unfinished; ++i) {
        const char *expected = name;
        if (atomic_compare_exchange_strong(&unfinished[i], &expected, NULL)) return;
    }
}

static void remove_unfinished(int signal_number)
{
    for (size_t i = 0; i < sizeof unfinished / sizeof *unfinished; ++i) {
        const char *name = atomic_load(&unfinished[i]);
        if (name) unlink(name);
    }
    raise(signal_number); /* SA_RESETHAND: this time the default action */
}

static void catch_signals(void)
{
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP, SIGPIPE};
    struct sigaction old, act = {.sa_handler = remove_unfinished, .sa_flags = (int)SA_RESETHAND};
    for (size_t i = 0; i < sizeof signals / sizeof *signals; ++i)
        if (!sigaction(signals[i], NULL, &old) && old.sa_handler == SIG_DFL) sigaction(signals[i], &act, NULL);
}

static bool is_temporary(const output *o)
{
    return o->name != o->target;
}

static void release(output *o)
{
    if (is_temporary(o)) forget(o->name), free(o->name);
    free(o->target);
    *o = (output){0};
}

/* "dir/picture.exr" -> "dir/.1234.picture.exr", which no listing shows and which keeps the extension. */
static char *temporary_beside(const char *target)
{
    const char *slash = strrchr(target, '/');
    size_t head = slash ? (size_t)(slash + 1 - target) : 0, size = strlen(target) + 40;
    char *name = malloc(size);
    if (name) snprintf(name, size, "%.*s.%ld.%s", (int)head, target, (long)getpid(), target + head);
    return name;
}

bool output_open(output *o, const char *path)
{
    *o = (output){.path = path};
    if (!strcmp(path, "-")) {
        o->file = stdout;
        return true;
    }
    struct stat st;
    bool exists = !stat(path, &st);
    o->target = exists ? realpath(path, NULL) : strdup(path);
    o->name = !o->target ? NULL : exists && !S_ISREG(st.st_mode) ? o->target : temporary_beside(o->target);
    if (!o->name) {
        report_no_memory(path);
        free(o->target);
        return false;
    }
    int flags = O_WRONLY | O_CREAT | O_CLOEXEC | (is_temporary(o) ? O_EXCL : 0);
    bool may = !exists || !access(o->target, W_OK); /* or a file that is write-protected would be replaced */
    int fd = may ? open(o->name, flags, exists ? st.st_mode & 0777 : 0666) : -1;
    if (fd >= 0 && is_temporary(o)) {
        remember(o->name);
        catch_signals();
    }
    o->file = fd >= 0 ? fdopen(fd, "wb") : NULL;
    if (!o->file) {
        report_file(path, "cannot write: %s", strerror(errno));
        if (fd >= 0) {
            close(fd);
            if (is_temporary(o)) unlink(o->name);
        }
        release(o);
        return false;
    }
    return true;
}

bool output_close(output *o)
{
    const char *path = o->target ? o->path : "<stdout>";
    bool failed = fflush(o->file) || ferror(o->file);
    int why = errno;
    if (o->target) {
        if (fclose(o->file) && !failed) failed = true, why = errno;
        if (!failed && is_temporary(o) && rename(o->name, o->target)) failed = true, why = errno;
        if (failed && is_temporary(o)) unlink(o->name);
    }
    if (failed) report_file(path, "cannot write: %s", strerror(why));
    release(o);
    return !failed;
}

void output_discard(output *o)
{
    if (o->target) {
        fclose(o->file);
        if (is_temporary(o)) unlink(o->name);
    }
    release(o);
}
