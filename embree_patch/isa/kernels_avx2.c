/* kernels_avx2.c - the kernels for avx2.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/isa/lanes_avx2.h"
#include "embree_patch/isa/table_tmpl.h"
