/* module.c - see module.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/shim/module.h"
#include "tools/report.h"

#include <dlfcn.h>
#include <stdlib.h>

void *module_function(void **module, const char *file, const char *name)
{
    if (!*module) *module = dlopen(file, RTLD_LAZY | RTLD_LOCAL);
    void *f = *module ? dlsym(*module, name) : NULL;
    if (f) return f;
    report((place){0}, "%s", dlerror());
    exit(1);
}
