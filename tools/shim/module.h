/* module.h - functions out of a module that is loaded when the first of them is called.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Large libraries take longer to load than most files of rays take to trace. What needs one is a module of its own,
 * so that only commands that use it wait for it. */
#ifndef EPATCH_MODULE_H
#define EPATCH_MODULE_H

/* The function; `module` is NULL at first. Ends the program when there is none: it is not installed as a whole then,
 * and nothing has been opened for writing yet. */
void *module_function(void **module, const char *file, const char *name);

#endif
