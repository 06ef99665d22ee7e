/* fuzz.c - inputs as files, outputs as one line.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#define _GNU_SOURCE /* memfd_create */
#include "test/fuzz/fuzz.h"
#include "tools/model.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static FILE *real_stderr;

static void require(bool ok, const char *what)
{
    if (ok) return;
    if (real_stderr) stderr = real_stderr;
    fprintf(stderr, "fuzz: %s\n", what);
    abort();
}

void fuzz_open(fuzz_file *f, const uint8_t *data, size_t size)
{
    *f = (fuzz_file){.fd = memfd_create("input", MFD_CLOEXEC)};
    require(f->fd >= 0, "no file in memory");
    require(write(f->fd, data, size) == (ssize_t)size, "the file in memory is cut");
    snprintf(f->path, sizeof f->path, "/proc/self/fd/%d", f->fd);
    real_stderr = stderr;
    stderr = open_memstream(&f->said, &f->said_size);
    require(stderr, "no stream in memory");
}

void fuzz_close(fuzz_file *f, bool read)
{
    fclose(stderr);
    stderr = real_stderr;
    if (read) {
        require(!f->said_size, "a reader that succeeds has something to say");
    } else {
        require(!strncmp(f->said, "epatch: ", 8), "a reader that fails does not say so");
        require(strchr(f->said, '\n') == f->said + f->said_size - 1, "a reader that fails says more than one line");
    }
    free(f->said);
    close(f->fd);
}

void fuzz_check_geometry(const scene_geometry *g)
{
    size_t points = 0;
    for (size_t i = 0; i < g->patch_count; ++i) {
        const patch *p = &g->patches[i];
        require(p->degree_u >= 1 && p->degree_u <= EP_MAX_DEGREE, "a degree in u");
        require(p->degree_v >= 1 && p->degree_v <= EP_MAX_DEGREE, "a degree in v");
        require(p->kind == PATCH_TENSOR || p->degree_u == p->degree_v, "the degrees of a triangle");
        require(p->first == points, "a patch does not begin where the last one ends");
        points += patch_point_count(p->kind, p->degree_u, p->degree_v);
    }
    if (g->cage) {
        require(points == g->cage_first, "a cage's vertices do not follow the patches");
        points += g->cage->vertex_count;
    }
    require(points == g->point_count, "the number of points");
    for (size_t i = 0; i < points; ++i) require(!point_problem(g->points + 4 * i), "a point");
}
