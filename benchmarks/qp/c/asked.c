#include <stddef.h>
#include "asked.h"

long asked_bytes;
int asked_counting;

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);

void *__wrap_malloc(size_t size)
{
    asked_bytes += asked_counting ? (long)size : 0;
    return __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    asked_bytes += asked_counting ? (long)(count * size) : 0;
    return __real_calloc(count, size);
}
