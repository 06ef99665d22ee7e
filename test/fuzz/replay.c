/* replay.c - the files of a folder, one after the other, through a fuzzer: a test that needs no libFuzzer.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/fuzz/fuzz.h"
#include "tools/files.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>

int main(int argc, char **argv)
{
    DIR *folder = argc == 2 ? opendir(argv[1]) : NULL;
    if (!folder) return puts("usage: replay FOLDER"), 2;
    unsigned files = 0;
    for (const struct dirent *e; (e = readdir(folder));) {
        char path[4096];
        size_t size;
        if (e->d_name[0] == '.') continue;
        snprintf(path, sizeof path, "%s/%s", argv[1], e->d_name);
        puts(path);
        fflush(stdout); /* the last one named is the one that crashes */
        char *data = input_read(path, &size);
        if (!data) return 1;
        LLVMFuzzerTestOneInput((const uint8_t *)data, size);
        free(data);
        ++files;
    }
    closedir(folder);
    printf("%u passed, 0 failed\n", files);
    return files == 0;
}
