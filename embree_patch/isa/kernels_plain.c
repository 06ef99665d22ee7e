/* kernels_plain.c - the kernels for any machine.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/isa/lanes_plain.h"
#include "embree_patch/isa/table_tmpl.h"
