/* SPDX-License-Identifier: MIT */
/*
 * What a fuzz target knows of one controller: tables made from its declaration. Host only; nothing
 * of this folder is part of an emitted package.
 */
#ifndef SG_FUZZ_H
#define SG_FUZZ_H

#include <stddef.h>
#include <stdint.h>

/* An input or output. `bounded`: low and high are declared. */
typedef struct {
    const char *name;
    size_t offset;
    int size; /* 0: a scalar */
    int integer;
    int bounded;
    double low;
    double high;
} sg_port;

/* An entry point; `call` returns the status, or -1 where there is none. */
typedef struct {
    const char *name;
    int (*call)(void *self, const void *in, void *out);
    size_t in_bytes;
    size_t out_bytes;
    const sg_port *in;
    int n_in;
    const sg_port *out;
    int n_out;
} sg_operation;

typedef struct {
    size_t bytes;
    size_t real_bytes;
    void (*init)(void *self);
    const sg_operation *operations;
    int n_operations;
    int n_statuses;
} sg_controller;

/* The controller under test; the generated file defines it. */
extern const sg_controller sg_fuzzed;

/* Seconds of processor time for one sequence of calls; the rest of it is dropped. */
extern double sg_fuzz_patience;

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#endif
