/* SPDX-License-Identifier: MIT */
/*
 * Plays the files of a corpus through a fuzz target, without libFuzzer. The standard output has the
 * name of each file before it is played: the last one is the culprit of an abort.
 */
#include <stdio.h>
#include <stdlib.h>

#include "sg_fuzz.h"

static uint8_t *read_file(const char *name, size_t *size)
{
    static uint8_t content[1 << 16];
    FILE *file = fopen(name, "rb");
    uint8_t *copy;
    if (file == NULL) {
        return NULL;
    }
    *size = fread(content, 1, sizeof content, file);
    fclose(file);
    copy = malloc((*size > 0) ? *size : 1); /* of that size exactly */
    for (size_t i = 0; (copy != NULL) && (i < *size); i++) {
        copy[i] = content[i];
    }
    return copy;
}

int main(int count, char **names)
{
    sg_fuzz_patience = 1.0e9;
    for (int i = 1; i < count; i++) {
        size_t size = 0;
        uint8_t *data = read_file(names[i], &size);
        printf("%s\n", names[i]);
        fflush(stdout);
        if (data == NULL) {
            return 2;
        }
        LLVMFuzzerTestOneInput(data, size);
        free(data);
    }
    return 0;
}
