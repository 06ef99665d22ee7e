/* bench_print.c - the figures for people: a table of numbers, then one of ratios.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/bench.h"
#include "tools/machine.h"
#include "tools/table.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* What is better when it is less: 1/300 rather than 0.0033. */
static void cell_part(table *t, double ratio)
{
    if (!(ratio < (double)INFINITY)) table_cell(t, "%s", "");
    else if (ratio >= 0.1) table_cell(t, "%.2f", ratio);
    else table_cell(t, "1/%.0f", 1 / ratio);
}

static void head(table *t, const bench *b, bool first)
{
    table_row(t);
    table_cell(t, "%s", "");
    if (first) {
        table_cell(t, "error");
        table_cell(t, "normal");
        table_cell(t, "memory");
    }
    table_cell(t, "build");
    const char *kind = "";
    for (unsigned w = 0; w < BENCH_WORKLOADS; ++w) {
        if (!(b->options.workloads >> w & 1)) continue;
        const bench_workload *x = &bench_workloads[w];
        const int length = (int)strcspn(x->name, "0123456789");
        if (!strncmp(kind, x->name, (size_t)length)) table_cell(t, "%u", x->width);
        else table_cell(t, "%.*s %u", length, x->name, x->width);
        kind = x->name;
    }
}

static void row(table *t, const bench *b, const bench_subject *s, unsigned column)
{
    table_row(t);
    if (s->n) table_cell(t, "%s %u×%u", bench_form_names[s->form], s->n, s->n);
    else table_cell(t, s == &b->limit ? "limit" : "patches");
    if (s != &b->limit) {
        if (!column) {
            table_cell(t, "%.1e", s->position_error);
            table_cell(t, "%.2g°", s->normal_error);
            table_bytes(t, s->bytes);
        }
        table_seconds(t, bench_median(&s->columns[column].build));
    } else {
        for (int i = 0; i < (column ? 1 : 4); ++i) table_cell(t, "%s", "");
    }
    for (unsigned w = 0; w < BENCH_WORKLOADS; ++w)
        if (b->options.workloads >> w & 1) table_figure(t, bench_median(&s->columns[column].speed[w]));
}

static void ratios(table *t, const bench *b, const bench_subject *s, unsigned column)
{
    const bench_column *p = &b->patches.columns[column], *q = &s->columns[column];
    table_row(t);
    if (s->form == WORLD_TRIANGLES) table_cell(t, "patches / %u×%u", s->n, s->n);
    else table_cell(t, "patches / %s %u×%u", bench_form_names[s->form], s->n, s->n);
    if (!column) {
        cell_part(t, b->patches.position_error / s->position_error);
        cell_part(t, b->patches.normal_error / s->normal_error);
        cell_part(t, (double)b->patches.bytes / (double)s->bytes);
    }
    cell_part(t, bench_median(&p->build) / bench_median(&q->build));
    for (unsigned w = 0; w < BENCH_WORKLOADS; ++w)
        if (b->options.workloads >> w & 1) table_figure(t, bench_median(&q->ratio[w]));
}

/* What more threads bring. */
static void scaling(table *t, const bench *b, unsigned column)
{
    table_row(t);
    table_cell(t, "patches, %u / %u threads", b->options.threads[column], b->options.threads[0]);
    table_cell(t, "%.2f", bench_median(&b->patches.columns[0].build) / bench_median(&b->patches.columns[column].build));
    for (unsigned w = 0; w < BENCH_WORKLOADS; ++w)
        if (b->options.workloads >> w & 1)
            table_figure(t, bench_median(&b->patches.columns[column].speed[w]) /
                                bench_median(&b->patches.columns[0].speed[w]));
}

static void print_column(const bench *b, unsigned column, bool markdown)
{
    table t = {0};
    head(&t, b, !column);
    for (unsigned k = 0; k < b->family_count; ++k)
        for (unsigned i = 0; i < b->families[k].count; ++i) row(&t, b, &b->families[k].grids[i], column);
    row(&t, b, &b->patches, column);
    row(&t, b, &b->limit, column);
    t.apart[t.rows] = true;
    for (unsigned k = 0; k < b->family_count; ++k) {
        const bench_family *f = &b->families[k];
        for (unsigned i = 0; i < f->count; ++i) {
            const unsigned n = f->grids[i].n;
            if (n == 64 || n == 256 || i + 1 == f->count) ratios(&t, b, &f->grids[i], column);
        }
    }
    if (column) scaling(&t, b, column);
    table_print(&t, markdown);
}

/* How much the runs of a figure differ from its median. */
typedef struct spread {
    double sum, count, most;
} spread;

static void add_spread(spread *to, const bench_subject *s, unsigned column)
{
    for (unsigned w = 0; w < BENCH_WORKLOADS; ++w) {
        const bench_figure *f = &s->columns[column].speed[w];
        for (unsigned r = 0; r < f->runs; ++r) {
            const double part = fabs(f->run[r] / bench_median(f) - 1);
            to->sum += part, to->count += 1;
            to->most = fmax(to->most, part);
        }
    }
}

/* How many threads, and how sure the figures are. */
static void print_heading(const bench *b, unsigned column)
{
    const unsigned threads = b->options.threads[column];
    spread all = {0};
    for (unsigned k = 0; k < b->family_count; ++k)
        for (unsigned i = 0; i < b->families[k].count; ++i) add_spread(&all, &b->families[k].grids[i], column);
    add_spread(&all, &b->patches, column);
    add_spread(&all, &b->limit, column);
    printf("Millions of rays a second with %u thread%s: ", threads, threads == 1 ? "" : "s");
    if (b->options.runs == 1) printf("one run.\n\n");
    else
        printf("medians of %u runs, which differ from them by %.1f %% on average, %.0f %% at most.\n\n",
               b->options.runs, 100 * all.sum / all.count, 100 * all.most);
}

/* How much the number of hits differs from another subject's. Bounces and segments do not count: they start on the
 * exact surface, which is inside of some triangles. */
static double difference_of_hits(const bench *b, const bench_subject *s)
{
    double most = -1;
    for (unsigned w = 0; w < BENCH_WORKLOADS; ++w) {
        const bench_kind kind = bench_workloads[w].kind;
        if (!(b->options.workloads >> w & 1) || (kind != BENCH_PRIMARY && kind != BENCH_RANDOM)) continue;
        most = fmax(most, fabs((double)b->patches.hits[w] - (double)s->hits[w]) / (double)b->rays.count[kind]);
    }
    return most;
}

static bool has_cage(const scene *s)
{
    for (size_t i = 0; i < s->geometry_count; ++i)
        if (s->geometries[i].cage) return true;
    return false;
}

static void print_legend(const bench *b)
{
    const bool matched = b->families[0].matched, cage = has_cage(b->scene);
    const bench_subject *last = bench_finest(&b->families[0]);
    printf("\n%u×%u triangles a %s are %sas exact as the patches", last->n, last->n, cage ? "face" : "patch",
           matched ? "" : "not ");
    if (!matched && last->n < b->options.max_grid)
        printf("; finer ones take more than %zu MB to build", b->options.memory >> 20);
    const double difference = difference_of_hits(b, last);
    if (difference >= 0)
        printf(".\nPrimary and random rays hit them as often as the patches, to %.2g %% of the rays", 100 * difference);
    puts(".\nRatios are medians of what the patches did right before and after a tessellation, by what that did.\n"
         "1: single rays; 16: packets. Error: the largest distance of a hit from the exact surface, relative to the\n"
         "scene's diagonal; normal: the largest angle. Memory and build count everything, Embree's part too. Limit:\n"
         "the hierarchy of the patches with a callback that only meets the leaf's plane.");
    if (b->family_count > 1) puts("Grids and subdivision: Embree's own geometries of the same cage.");
    else if (cage)
        puts("Embree's own subdivision is left out: it is for scenes of cages alone, by Catmull and Clark's usual rules and\n"
             "without holes, which it takes for the same surfaces.");
}

void bench_print(const bench *b, bool markdown)
{
    const machine m = machine_describe();
    EPStatistics statistics;
    epGetGeometryStatistics(b->patches.world->geometries[0], &statistics);
    printf("%s, %zu leaves. %s, %u cores, %s; Embree %s; %s.\n", b->scene->path, b->patches.world->leaves, m.cpu,
           m.cores, statistics.isa, m.embree, m.compiler);
    for (unsigned c = 0; c < b->options.columns; ++c) {
        if (c || markdown) putchar('\n');
        print_heading(b, c);
        print_column(b, c, markdown);
    }
    print_legend(b);
}
