/* epatch.c - the program: a table of commands.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#define _XOPEN_SOURCE 700 /* SIGXFSZ */
#include "tools/args.h"
#include "tools/commands.h"
#include "tools/report.h"

#include "embree_patch/embree_patch.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

typedef struct command {
    const char *name, *help;
    int (*run)(int argc, char **argv);
} command;

static const command commands[] = {
    {"render", "draws a scene or a model", cmd_render},
    {"trace", "answers a file of rays with a file of hits", cmd_trace},
    {"bench", "measures the patches against tessellations of every density", cmd_bench},
    {"info", "tells what is in a scene, and the statistics of its hierarchy", cmd_info},
    {"verify", "holds the kernels against a slow reference, ray by ray", cmd_verify},
};

static int help(void)
{
    puts("usage: epatch COMMAND SCENE [options]\n\n"
         "Ray traces curved patches exactly. SCENE is a scene (.json) or a model file\n"
         "(.bpt, .obj, .step, .stp, .iges, .igs, .brep).\n");
    for (size_t i = 0; i < ARG_COUNT(commands); ++i) printf("  %-8s %s\n", commands[i].name, commands[i].help);
    puts("\nepatch COMMAND --help tells the rest.");
    return 0;
}

static int run(int argc, char **argv)
{
    const char *names[ARG_COUNT(commands)];
    if (argc < 2) return report((place){0}, "no command (see epatch --help)"), 2;

    const char *name = argv[1];
    if (!strcmp(name, "--help") || !strcmp(name, "-h")) return help();
    if (!strcmp(name, "--version")) return puts("epatch " EP_VERSION_STRING), 0;
    for (size_t i = 0; i < ARG_COUNT(commands); ++i) {
        names[i] = commands[i].name;
        if (!strcmp(name, names[i])) return commands[i].run(argc - 1, argv + 1);
    }
    const char *nearest = args_nearest(name, names, ARG_COUNT(names));
    if (nearest) report((place){0}, "no command '%s'; did you mean '%s'? (see epatch --help)", name, nearest);
    else report((place){0}, "no command '%s' (see epatch --help)", name);
    return 2;
}

/* Where a standard stream is closed, the next file opened would take its place, and messages would go into a picture.
 * What stands there instead fails to be read, or to be written. */
static void occupy_standard_streams(void)
{
    for (int fd = 0; fd <= 2; ++fd)
        if (fcntl(fd, F_GETFD) < 0) open("/dev/null", fd ? O_RDONLY : O_WRONLY);
}

int main(int argc, char **argv)
{
    occupy_standard_streams();
    signal(SIGXFSZ, SIG_IGN); /* a limit on file sizes is then an error of write() like a full disk */
    int status = run(argc, argv);

    bool failed = fflush(stdout) || ferror(stdout);
    if (failed && !status) {
        report_file("<stdout>", "cannot write: %s", strerror(errno));
        status = 1;
    }
    return status;
}
