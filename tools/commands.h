/* commands.h - the commands of epatch. Each takes its own argv (argv[0] is the command's name) and returns the
 * exit status: 0 done, 1 the work failed, 2 wrong usage. A new command is a line here and one in epatch.c.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_COMMANDS_H
#define EPATCH_COMMANDS_H

int cmd_render(int argc, char **argv);
int cmd_trace(int argc, char **argv);
int cmd_info(int argc, char **argv);
int cmd_bench(int argc, char **argv);
int cmd_verify(int argc, char **argv);

#endif
