/* stats.c - numbers of a run as JSON.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/stats.h"
#include "tools/files.h"
#include "tools/report.h"

#include <stdlib.h>
#include <string.h>

json_t *stats_of_world(const world *w)
{
    const char *isa = "";
    if (w->scene->geometry_count) {
        EPStatistics statistics;
        epGetGeometryStatistics(w->geometries[0], &statistics);
        if (statistics.isa) isa = statistics.isa;
    }
    const world_size size = world_measure(w);
    return json_pack("{s:f, s:I, s:I, s:I, s:s}", "build_seconds", w->build_seconds, "bytes_patches",
                     (json_int_t)size.bytes_patches, "bytes_embree", (json_int_t)size.bytes_embree, "leaves",
                     (json_int_t)size.leaves, "isa", isa);
}

double stats_mean_iterations(const EPCounters *cost)
{
    return cost->solves ? (double)cost->evaluations / (double)cost->solves : 0;
}

json_t *stats_of_cost(const EPCounters *cost)
{
    return json_pack("{s:f, s:I, s:I, s:I, s:I}", "newton_iterations_mean", stats_mean_iterations(cost),
                     "slow_path_rays", (json_int_t)cost->slow, "visits", (json_int_t)cost->visits, "solves",
                     (json_int_t)cost->solves, "cells", (json_int_t)cost->cells);
}

json_t *stats_name(const char *path)
{
    json_t *name = json_string(path);
    if (name) return name;
    char *ascii = strdup(path);
    for (char *c = ascii; c && *c; ++c)
        if (*c & 0x80) *c = '?';
    name = ascii ? json_string(ascii) : NULL;
    free(ascii);
    return name;
}

bool stats_add(json_t *object, json_t *more)
{
    bool done = object && more && !json_object_update(object, more);
    json_decref(more);
    return done;
}

bool stats_write(const char *path, json_t *object)
{
    output o;
    if (!object) {
        report_no_memory(path);
        return false;
    }
    bool done = output_open(&o, path);
    if (done) {
        json_dumpf(object, o.file, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
        fputc('\n', o.file);
        done = output_close(&o);
    }
    json_decref(object);
    return done;
}
