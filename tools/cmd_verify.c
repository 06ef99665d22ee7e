/* cmd_verify.c - `epatch verify`: the kernels against the oracle.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/args.h"
#include "tools/commands.h"
#include "tools/files.h"
#include "tools/report.h"
#include "tools/verify.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const unsigned widths[] = {1, 4, 8, 16};

typedef struct verify_command {
    const char *scene, *replay, *save, *isa;
    unsigned width; /* index into widths; 4: all */
    verify_options o;
} verify_command;

static void choose_setups(verify_command *c)
{
    for (const char *const *isa = epGetInstructionSets(); *isa; ++isa) {
        if (strcmp(c->isa, "all") && strcmp(c->isa, *isa)) continue;
        for (unsigned w = 0; w < ARG_COUNT(widths); ++w)
            if (c->width == ARG_COUNT(widths) || c->width == w)
                c->o.setups[c->o.setup_count++] = (verify_setup){widths[w], *isa};
    }
}

/* Returns the number of faults. */
static size_t print(const verify_options *o, const verify_report *r)
{
    size_t faults = 0;
    puts("rays    width isa       traced     hits  missed   extra  wrong t   place  normal  occluded    bits  "
         "left out   error of t  degrees   slow %");
    for (int kind = 0; kind < AIM_KINDS; ++kind)
        for (size_t k = 0; k < o->setup_count; ++k) {
            const verify_row *row = &r->rows[kind][k];
            const size_t *v = row->verdicts;
            if (!row->rays) continue;
            printf("%-8s%5u %-7s %9zu%9zu%8zu%8zu%9zu%8zu%8zu%10zu%8zu%10zu%13.1e%9.3f%9.3f\n", aim_names[kind],
                   o->setups[k].width, o->setups[k].isa, row->rays, row->hits, v[JUDGE_MISSED], v[JUDGE_EXTRA],
                   v[JUDGE_WRONG_T], v[JUDGE_WRONG_PLACE], v[JUDGE_WRONG_NORMAL], row->occluded, row->bits,
                   v[JUDGE_LEFT_OUT], row->most.t, row->most.degrees, 100.0 * (double)row->slow / (double)row->rays);
            faults += verify_faults(row);
        }
    return faults;
}

static bool save(const char *path, const verify_report *r)
{
    output out;
    if (!output_open(&out, path)) return false;
    if (r->wrong_count) fwrite(r->wrong, sizeof *r->wrong, r->wrong_count, out.file);
    return output_close(&out);
}

static bool run(const verify_command *c)
{
    scene *s = scene_read(c->scene);
    if (!s) return false;
    verify_report r = {0};
    bool done;
    if (c->replay) {
        size_t count;
        trace_ray *rays = trace_read_rays(c->replay, &count);
        done = rays && verify_rays(s, rays, count, &c->o, &r);
        free(rays);
    } else {
        done = verify_scene(s, &c->o, &r);
    }
    if (done) {
        const size_t faults = print(&c->o, &r);
        if (faults) report_file(c->scene, "%zu faults on %zu rays", faults, r.wrong_count);
        done = !faults;
        if (c->save) done = save(c->save, &r) && done;
        free(r.wrong);
    }
    scene_free(s);
    return done;
}

int cmd_verify(int argc, char **argv)
{
    verify_command c = {
        .isa = "all", .width = ARG_COUNT(widths), .o = {.rays = 20000, .seed = 1, .limits = judge_usual, .explain = 5}};
    unsigned rays = 20000, seed = 1;
    const arg_option options[] = {
        ARG_UNSIGNED("--rays", "N", &rays, 1, 1u << 30, "rays of each kind (20000)"),
        ARG_UNSIGNED("--seed", "S", &seed, 0, ~0u, "of the random rays (1)"),
        ARG_CHOICE("--width", "1|4|8|16|all", &c.width, "rays a packet (all)"),
        ARG_STRING("--isa", "all|plain|avx2|avx512", &c.isa, "instruction sets of the kernels (all that run here)"),
        ARG_STRING("--replay", "FILE", &c.replay, "these rays, as `trace` reads them, instead of random ones"),
        ARG_STRING("--save", "FILE", &c.save, "write the rays that went wrong, as `trace` reads them"),
        ARG_UNSIGNED("--explain", "N", &c.o.explain, 0, ~0u, "print so many of the faults of a geometry (5)"),
        ARG_UNSIGNED("--threads", "N", &c.o.threads, 0, 1024, "at most so many threads; 0: all (0)"),
    };
    const arg_table table = {
        "verify SCENE",
        "Holds the kernels against a slow reference in double precision: random rays at every geometry\n"
        "of the scene by itself, as it is or where an object puts it. A fault is a hit missed, one too\n"
        "many, a wrong t (2e-5 relative), u, v or normal (0.25 degrees), an occlusion query that\n"
        "disagrees, or other bits in another width or instruction set, or where the ray ends at its hit.\n"
        "Rays that a rounding could turn from hit to miss, within 2e-3 of tangency, 1e-5 of a border or\n"
        "2e-5 of a trim, are left out.\n"
        "Exit status 1 when there is a fault.",
        "SCENE",
        &c.scene,
        options,
        ARG_COUNT(options)};
    int status = args_parse(&table, argc, argv);
    if (status != ARGS_GO) return status;
    c.o.rays = rays;
    c.o.seed = seed;
    choose_setups(&c);
    if (!c.o.setup_count) return args_wrong(&table, "--isa is '%s', which this machine does not run", c.isa);
    return run(&c) ? 0 : 1;
}
