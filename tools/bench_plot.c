/* bench_plot.c - six small pictures with the error of each subject to the right.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * All axes are logarithmic, so that a tessellation twice as fine is one step along a nearly straight line. The patches
 * are one point; the dotted line through it shows which tessellations it beats. gnuplot does the drawing: it gets its
 * script from a temporary file as standard input. */
#include "tools/bench.h"
#include "tools/files.h"
#include "tools/machine.h"
#include "tools/report.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <spawn.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

/* Runs gnuplot quietly. The exit status, or -1 when it cannot be started; errno says why. */
static int run_gnuplot(char *const argv[], int script)
{
    posix_spawn_file_actions_t actions;
    pid_t pid;
    int status;
    posix_spawn_file_actions_init(&actions);
    if (script >= 0) posix_spawn_file_actions_adddup2(&actions, script, STDIN_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    errno = posix_spawnp(&pid, argv[0], &actions, NULL, argv, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (errno) return -1;
    while (waitpid(pid, &status, 0) < 0)
        if (errno != EINTR) return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

bool bench_plot_possible(const char *path)
{
    char *const argv[] = {"gnuplot", "--version", NULL};
    if (!run_gnuplot(argv, -1)) return true;
    report_file(path, "--plot needs gnuplot, which is not installed (Debian: gnuplot-nox)");
    return false;
}

/* One small picture: what stands over it, and the figure that it shows. */
typedef struct panel {
    const char *title;
    double (*value)(const bench_subject *s, unsigned workload);
    const char *workload;
} panel;

static double speed(const bench_subject *s, unsigned w)
{
    return bench_median(&s->columns[0].speed[w]);
}

static double megabytes(const bench_subject *s, unsigned w)
{
    (void)w;
    return (double)s->bytes / 1e6;
}

static double milliseconds(const bench_subject *s, unsigned w)
{
    (void)w;
    return 1e3 * bench_median(&s->columns[0].build);
}

static const panel panels[] = {
    {"Primary rays in packets of 16, Mray/s", speed, "primary16"},
    {"Random rays in packets of 16, Mray/s", speed, "random16"},
    {"Memory, MB", megabytes, NULL},
    {"Single primary rays, Mray/s", speed, "primary1"},
    {"Single random rays, Mray/s", speed, "random1"},
    {"Time to build, ms", milliseconds, NULL},
};

/* In single quotes, on one line. */
static void quote(FILE *f, const char *text)
{
    fputc('\'', f);
    for (; *text; ++text) {
        if (*text == '\'') fputc('\'', f);
        fputc((unsigned char)*text < 32 ? '?' : *text, f);
    }
    fputc('\'', f);
}

/* Range and ticks of an axis: the more decades, the fewer ticks in each. */
static void write_axis(FILE *f, char axis, bool powers, double least, double most)
{
    static const unsigned ticks[3][8] = {{1, 0}, {1, 2, 5, 0}, {1, 2, 3, 4, 5, 6, 8, 0}};
    const unsigned *steps = ticks[most / least > 300 ? 0 : most / least > 20 || powers ? 1 : 2];
    fprintf(f, "set %crange [%.9g:%.9g]\nset %ctics (", axis, least, most, axis);
    const char *comma = "";
    for (int e = (int)floor(log10(least)); e <= (int)ceil(log10(most)); ++e)
        for (const unsigned *k = steps; *k; ++k, comma = ", ") {
            const double at = *k * pow(10, e);
            if (!powers) fprintf(f, "%s'%g' %.9g", comma, at, at);
            else if (*k == 1) fprintf(f, "%s'10^{%d}' %.9g", comma, e, at);
            else fprintf(f, "%s'%u·10^{%d}' %.9g", comma, *k, e, at);
        }
    fprintf(f, ")\n");
}

/* Each form of tessellation has a line of its own; triangles, the first, have theirs labelled. */
static const char *const colours[BENCH_FORMS] = {
    [WORLD_TRIANGLES] = "#4c78a8", [WORLD_GRIDS] = "#8a6fb0", [WORLD_SUBDIVISION] = "#3d8f5f"};

static void write_panel(FILE *f, const bench *b, const panel *p, unsigned w)
{
    const double at = b->patches.position_error, here = p->value(&b->patches, w);
    /* the nearest point: the label keeps away from it */
    const double finest = p->value(bench_finest(&b->families[0]), w);
    double least = here, most = here;
    for (unsigned k = 0; k < b->family_count; ++k) {
        fprintf(f, "$%s << EOD\n", bench_form_names[b->families[k].form]);
        for (unsigned i = 0; i < b->families[k].count; ++i) {
            const bench_subject *s = &b->families[k].grids[i];
            const double y = p->value(s, w);
            fprintf(f, "%.9g %.9g %u\n", s->position_error, y, s->n);
            least = fmin(least, y), most = fmax(most, y);
        }
        fprintf(f, "EOD\n");
    }
    fprintf(f, "set title '%s'\n", p->title);
    const bool more = p->workload; /* is better */
    fprintf(f, "set label 4 '%s' at graph 0.985,%s right font ',11' tc rgb '#999999'\n", more ? "↑ better" : "↓ better",
            more ? "0.06" : "0.94");
    const double room = 1.2 * pow(most / least, 0.14); /* for the labels */
    write_axis(f, 'y', false, least / room, most * room);
    fprintf(f, "$patches << EOD\n%.9g %.9g patches\nEOD\nplot %.9g with lines lc rgb '#e8590c' lw 1 dt 3, \\\n", at,
            here, here);
    for (unsigned k = 0; k < b->family_count; ++k)
        fprintf(f, "  $%s using 1:2 with linespoints lc rgb '%s' lw 1.6 pt 7 ps 0.55, \\\n",
                bench_form_names[b->families[k].form], colours[b->families[k].form]);
    fprintf(f,
            "  $triangles using 1:2:3 with labels boxed tc rgb '#44586c' font ',11' offset 0,0.75, \\\n"
            "  $patches using 1:2 with points lc rgb '#e8590c' pt 7 ps 1.1, \\\n"
            "  $patches using 1:2:3 with labels tc rgb '#c2410c' font ',13' offset 0,%g\n",
            here < finest ? -1.1 : 1.1);
}

/* As much of a path as the caption has room for: its last part, whole characters of UTF-8 of it. */
static const char *short_name(const char *path, int *length)
{
    enum { ROOM = 60 };
    const char *slash = strrchr(path, '/'), *name = slash && strlen(path) > ROOM ? slash + 1 : path;
    size_t n = strlen(name);
    if (n > ROOM)
        for (n = ROOM; n && ((unsigned char)name[n] & 0xC0) == 0x80;) --n;
    *length = (int)n;
    return name;
}

/* Over and under the pictures. */
static void write_captions(FILE *f, const bench *b)
{
    const machine m = machine_describe();
    EPStatistics statistics;
    char text[400];
    epGetGeometryStatistics(b->patches.world->geometries[0], &statistics);
    int length;
    const char *name = short_name(b->scene->path, &length);
    snprintf(text, sizeof text, "%.*s: exact patches, and n × n triangles a %s", length, name,
             b->family_count > 1 ? "face (blue), Embree's grids (violet) and subdivision (green)" : "patch");
    fprintf(f, "set label 1 ");
    quote(f, text);
    fprintf(f, " at screen 0.012,0.965 left font ',16' noenhanced\nset label 2 ");
    snprintf(text, sizeof text, "%s, %s, %u thread%s; Embree %s", m.cpu, statistics.isa, b->options.threads[0],
             b->options.threads[0] == 1 ? "" : "s", m.embree);
    quote(f, text);
    fprintf(f, " at screen 0.988,0.02 right tc rgb '#777777' noenhanced\n"
               "set label 3 '← better      largest error of a hit, relative to the diagonal of the scene' at screen "
               "0.012,0.02 left\n");
}

static void write_script(FILE *f, const bench *b, const char *name)
{
    double least = b->patches.position_error, most = least;
    for (unsigned k = 0; k < b->family_count; ++k)
        for (unsigned i = 0; i < b->families[k].count; ++i) {
            least = fmin(least, b->families[k].grids[i].position_error);
            most = fmax(most, b->families[k].grids[i].position_error);
        }
    fprintf(f,
            "set encoding utf8\nset terminal svg size 1180,640 font 'Helvetica,13' background '#ffffff'\nset output ");
    quote(f, name);
    fprintf(f, "\nset multiplot layout 2,3 margins 0.045,0.985,0.09,0.875 spacing 0.055,0.15\n"
               "set style textbox opaque noborder fc rgb '#ffffff' margins 0.3,0.2\n"
               "unset key\nset border 3 lc rgb '#888888'\nset tics nomirror scale 0.5 tc rgb '#555555'\n"
               "set logscale xy\nset grid lc rgb '#e6e6e6' lt 1\nset title font ',13' offset 0,-0.4\n");
    write_captions(f, b);
    write_axis(f, 'x', true, least / 4, most * 2);
    for (size_t i = 0; i < sizeof panels / sizeof *panels; ++i) {
        unsigned w = 0;
        while (panels[i].workload && strcmp(panels[i].workload, bench_workloads[w].name)) ++w;
        if (panels[i].workload && !(b->options.workloads >> w & 1)) fprintf(f, "set multiplot next\n");
        else write_panel(f, b, &panels[i], w), fprintf(f, "unset label\n");
    }
    fprintf(f, "unset multiplot\nset output\n");
}

/* NULL, or what is wrong. */
static const char *draw(FILE *script, const bench *b, const char *name)
{
    char *const argv[] = {"gnuplot", "-", NULL};
    if (script) write_script(script, b, name);
    if (!script || fflush(script) || ferror(script) || fseek(script, 0, SEEK_SET))
        return "cannot write the script for gnuplot";
    const int status = run_gnuplot(argv, fileno(script));
    return !status ? NULL : status < 0 ? "cannot start gnuplot" : "gnuplot failed";
}

bool bench_plot(const bench *b, const char *path)
{
    output o;
    if (!output_open(&o, path)) return false;
    FILE *script = tmpfile();
    const char *problem = draw(script, b, o.name);
    if (script) fclose(script);
    if (!problem) return output_close(&o);
    report_file(path, "%s", problem);
    output_discard(&o);
    return false;
}
