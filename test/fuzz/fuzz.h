/* fuzz.h - what the fuzzers of the readers share. One fuzzer a reader, in libFuzzer's form; its corpus is replayed as
 * an ordinary test by replay.c. To search for new inputs:
 *
 *     CC=clang CXX=clang++ meson setup build-fuzz -Db_sanitize=address,undefined -Db_lundef=false
 *     ninja -C build-fuzz test/fuzz/fuzz_scene
 *     build-fuzz/test/fuzz/fuzz_scene -max_len=4096 test/fuzz/corpus/scene
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef TEST_FUZZ_H
#define TEST_FUZZ_H

#include "tools/scene.h"

#include <stdint.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* A file that holds the input, and standard error in memory. */
typedef struct fuzz_file {
    char path[40];
    int fd;
    char *said;
    size_t said_size;
} fuzz_file;

void fuzz_open(fuzz_file *f, const uint8_t *data, size_t size);

/* A reader that is content says nothing; one that is not says one line. Aborts otherwise. */
void fuzz_close(fuzz_file *f, bool read);

/* What was read is what the rest of the program may rely on. Aborts otherwise. */
void fuzz_check_geometry(const scene_geometry *g);

#endif
