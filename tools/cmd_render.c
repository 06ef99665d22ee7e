/* cmd_render.c - `epatch render`: a scene or a model in, a picture out.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/args.h"
#include "tools/commands.h"
#include "tools/files.h"
#include "tools/outline.h"
#include "tools/render.h"
#include "tools/report.h"
#include "tools/shim/image.h"
#include "tools/stats.h"
#include "tools/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Enough to know a model's outline when the camera is placed; more would only take time. */

typedef struct render_command {
    const char *scene, *image, *stats, *panorama;
    unsigned size[2], spp, threads, layers, up;
    bool has_camera, ground;
    camera camera;
    world_options world;
} render_command;

static bool write_stats(const render_command *c, const world *w, const render_result *r)
{
    double speed = r->seconds > 0 ? (double)r->rays / r->seconds : 0;
    json_t *o = json_pack("{s:I, s:I, s:f, s:f, s:i, s:i, s:i, s:i}", "rays", (json_int_t)r->rays, "camera_rays",
                          (json_int_t)r->camera_rays, "seconds", r->seconds, "rays_per_second", speed, "threads",
                          (int)trace_threads(c->threads), "width", (int)c->size[0], "height", (int)c->size[1], "spp",
                          (int)c->spp);
    bool complete = stats_add(o, stats_of_world(w));
    complete = stats_add(o, stats_of_cost(&r->cost)) && complete;
    if (!complete) json_decref(o), o = NULL;
    return stats_write(c->stats, o);
}

/* Renders and writes, once camera and light are there. */
static bool draw(const render_command *c, const world *w, const view *v, const light *l, output *image)
{
    shader s;
    film f;
    if (!shader_new(&s, w, l, !c->world.tessellation, c->ground)) return report_no_memory(c->scene), false;
    if (!film_new(&f, c->size[0], c->size[1], c->layers)) {
        report_file(c->image, "out of memory for %ux%u pixels", c->size[0], c->size[1]);
        shader_free(&s);
        return false;
    }
    render_result result;
    render(&s, v, c->spp, c->threads, &f, &result);
    bool done = film_write(&f, image) && (!c->stats || write_stats(c, w, &result));
    film_free(&f);
    shader_free(&s);
    return done;
}

static bool frame_and_draw(const render_command *c, const world *w, const camera *given, output *image)
{
    camera cam;
    if (given) {
        cam = *given;
    } else {
        size_t count;
        double(*points)[3] = outline_new(w, &count);
        if (!points) return report_no_memory(c->scene), false;
        cam = camera_framing((const double(*)[3])points, count, c->up ? c->up : w->scene->up, c->size[0], c->size[1]);
        free(points);
    }
    view v;
    light l;
    if (!view_of_camera(&v, &cam, c->size[0], c->size[1]))
        return report_file(c->scene, "the camera has no direction: its eye is its target"), false;
    if (!c->panorama) light_studio(&l, &v);
    else if (!light_panorama(&l, &v, c->panorama)) return false;
    bool done = draw(c, w, &v, &l, image);
    light_free(&l);
    return done;
}

static bool run(render_command *c)
{
    output image; /* opened first: better to hear now that it cannot be written */
    if (!output_open(&image, c->image)) return false;
    image_threads(c->threads);

    bool done = false;
    world *w = NULL;
    scene *s = scene_read(c->scene);
    if (s) {
        const camera *given = c->has_camera ? &c->camera : s->has_camera ? &s->camera : NULL;
        c->world.threads = c->threads;
        c->world.ray_distance = outline_reach(s, given);
        w = world_new(s, &c->world);
        if (w) done = frame_and_draw(c, w, given, &image);
    }
    if (image.file) output_discard(&image); /* it did not come to writing */
    world_free(w);
    scene_free(s);
    return done;
}

int cmd_render(int argc, char **argv)
{
    static const char *const sets[] = {NULL, "plain", "avx2", "avx512"};
    render_command c = {.size = {1280, 720}, .spp = 16, .world.build = epDefaultBuildSettings()};
    double placed[10] = {[9] = NAN};
    unsigned up = 0, isa = 0;
    bool on_demand = false;
    const arg_option options[] = {
        ARG_STRING("-o, --output", "IMAGE", &c.image, "the picture; its extension says the format"),
        ARG_SIZE("--size", "WxH", c.size, "pixels (1280x720)"),
        ARG_UNSIGNED("--spp", "N", &c.spp, 1, 65536, "samples a pixel (16)"),
        ARG_DOUBLES("--camera", "ex,ey,ez,tx,ty,tz,ux,uy,uz,fov", placed, 10,
                    "eye, target, up, vertical angle in degrees\n(the scene's, else one that frames the model)"),
        ARG_CHOICE("--up", "auto|y|z", &up, "the axis that is up when the model is framed (y for\n.obj files, else z)"),
        ARG_FLAG("--ground", &c.ground, "a floor under the model, to catch its shadow"),
        ARG_STRING("--environment", "IMAGE", &c.panorama,
                   "a panorama to light the scene with (latitude-\nlongitude) in place of a studio"),
        ARG_SET("--aov", FILM_LAYER_WORDS, &c.layers,
                "more layers in the same image, which must be an\nEXR or TIFF; a ray through each pixel's centre"),
        ARG_CHOICE_N("--as", "patches|triangles:N", &c.world.tessellation, 1, 8192,
                     "exact patches, or each an N x N grid of Embree\ntriangles (patches)"),
        ARG_FLAG("--on-demand", &on_demand, "cut a patch into leaves when a ray first meets it"),
        ARG_UNSIGNED("--threads", "N", &c.threads, 0, 1024, "at most so many threads; 0: all (0)"),
        ARG_STRING("--stats", "FILE", &c.stats, "counts and times as JSON"),
        ARG_CHOICE("--isa", "best|plain|avx2|avx512", &isa, "instruction set of the kernels (best)"),
    };
    const arg_table table = {"render SCENE -o IMAGE",
                             "Draws a scene, or any model: a model is framed and lit by itself.",
                             "SCENE",
                             &c.scene,
                             options,
                             ARG_COUNT(options)};
    int status = args_parse(&table, argc, argv);
    if (status != ARGS_GO) return status;
    if (!c.image) return args_wrong(&table, "-o IMAGE is missing");
    if (on_demand && c.world.tessellation) return args_wrong(&table, "--on-demand is for exact patches");
    char why[500];
    if (c.stats && !strcmp(c.image, c.stats))
        return args_wrong(&table, "the picture and the stats cannot both go to %s", c.image);
    if (!film_suits(c.image, c.layers, why, sizeof why)) return args_wrong(&table, "%s", why);

    c.has_camera = !isnan(placed[9]);
    if (c.has_camera) {
        view v;
        memcpy(c.camera.eye, placed, sizeof c.camera.eye);
        memcpy(c.camera.target, placed + 3, sizeof c.camera.target);
        memcpy(c.camera.up, placed + 6, sizeof c.camera.up);
        c.camera.fov = placed[9];
        if (!(c.camera.fov > 0 && c.camera.fov < 180))
            return args_wrong(&table, "--camera: the angle must be between 0 and 180 degrees");
        if (!view_of_camera(&v, &c.camera, c.size[0], c.size[1]))
            return args_wrong(&table, "--camera: the eye is the target");
    }
    c.up = up;
    c.world.build.isa = sets[isa];
    c.world.build.onDemand = on_demand;
    return run(&c) ? 0 : 1;
}
