/* kernels_avx512.c - the kernels for avx512.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/isa/lanes_avx512.h"
#include "embree_patch/isa/table_tmpl.h"
