/* model_cad.c - STEP, IGES and BREP files: the faces, in the file's order, as trimmed NURBS surfaces.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A face that cannot be traced is left out with a message and keeps its number, so that the others keep theirs. */
#include "tools/loops.h"
#include "tools/files.h"
#include "tools/model.h"
#include "tools/nurbs.h"
#include "tools/progress.h"
#include "tools/report.h"
#include "tools/shim/cad.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

typedef struct faces {
    const char *path;
    scene_geometry *g;
    progress progress;
    bool no_memory;
} faces;

static const char *add_loop(loops *l, const cad_loop *from)
{
    const char *problem = loops_begin_loop(l);
    for (size_t i = 0; i < from->count && !problem; ++i) {
        const cad_curve *c = &from->curves[i];
        problem = loops_add_curve(l, c->degree, c->knot_count, c->knots, c->count, c->points);
    }
    return problem ? problem : loops_end_loop(l);
}

static const char *make_trim(scene_geometry *g, const cad_face *f, EPRegion *region, struct trim_shape **shape)
{
    if (!f->loop_count) return NULL;
    loops l;
    const char *problem = loops_begin(&l);
    for (size_t i = 0; i < f->loop_count && !problem; ++i) problem = add_loop(&l, &f->loops[i]);
    if (!problem) problem = loops_end(&l, g, region, shape);
    loops_free(&l);
    return problem;
}

static const char *add_face(scene_geometry *g, uint32_t index, const cad_face *f)
{
    EPRegion region = NULL;
    struct trim_shape *shape = NULL;
    const nurbs n = {{f->degree[0], f->degree[1]},
                     {f->count[0], f->count[1]},
                     {f->knot_count[0], f->knot_count[1]},
                     {f->knots[0], f->knots[1]},
                     f->points};
    const char *problem = make_trim(g, f, &region, &shape);
    if (!problem) problem = geometry_add_nurbs(g, index, &n, region, shape);
    epReleaseRegion(region);
    return problem;
}

static bool take(void *user, uint32_t index, uint32_t total, const cad_face *f, const char *problem)
{
    faces *to = user;
    if (!index) progress_begin(&to->progress, "faces", total);
    if (f) problem = add_face(to->g, index, f);
    to->no_memory = problem && !strcmp(problem, "out of memory");
    if (problem && !to->no_memory) report_file(to->path, "face %u is left out: %s", index, problem);
    progress_add(&to->progress, 1);
    if (index + 1 == total || to->no_memory) progress_end(&to->progress);
    return !to->no_memory;
}

static bool read_faces(const char *path, cad_format format, scene_geometry *g)
{
    FILE *file = fopen(path, "rb");
    if (!file) return report_file(path, "cannot open: %s", strerror(errno)), false;
    struct stat st;
    const bool is_regular = !fstat(fileno(file), &st) && (S_ISREG(st.st_mode) || S_ISDIR(st.st_mode));
    const bool is_readable = is_regular && (fgetc(file) != EOF || !ferror(file));
    if (!is_regular) report_file(path, "CAD files are read more than once, so not from a pipe or a device");
    else if (!is_readable) report_file(path, "cannot read: %s", strerror(errno));
    fclose(file);
    if (!is_readable) return false;

    faces to = {.path = path, .g = g};
    const char *problem = cad_read(path, format, take, &to);
    if (!problem && !to.no_memory && !g->patch_count) problem = "no face of it can be traced";
    if (problem) report_file(path, "%s", problem);
    else if (to.no_memory) report_no_memory(path);
    return !problem && !to.no_memory;
}

bool model_read_step(const char *path, const model_options *o, scene_geometry *g)
{
    (void)o;
    return read_faces(path, CAD_STEP, g);
}

bool model_read_iges(const char *path, const model_options *o, scene_geometry *g)
{
    (void)o;
    return read_faces(path, CAD_IGES, g);
}

bool model_read_brep(const char *path, const model_options *o, scene_geometry *g)
{
    (void)o;
    return read_faces(path, CAD_BREP, g);
}
