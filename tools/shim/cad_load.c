/* cad_load.c - the function of cad.h, out of a module that is loaded when it is called.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * OpenCASCADE comes with some dozens of libraries. */
#include "tools/shim/cad.h"
#include "tools/shim/module.h"

const char *cad_read(const char *path, cad_format format, cad_taker take, void *user)
{
    static void *module;
    return MODULE_CALL(&module, "epatch_cad.so", cad_read, path, format, take, user);
}
