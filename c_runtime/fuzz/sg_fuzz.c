/* SPDX-License-Identifier: MIT */
/*
 * Bytes become a sequence of calls on one controller, and every call is judged.
 *
 * Format: each call is two bytes and its changes. Byte 0: which operation (the low six bits), and
 * whether a stranger is called in between (bit 6). Byte 1: how many inputs change (the low three
 * bits); an operation without inputs is called 1 + (byte 1 / 8)^2 / 4 times instead. Inputs that do not
 * change are those of the last call of the same operation; at first they are at rest. A change is
 * the number of the port, a kind, and what the kind asks for. Nothing depends on the size of an
 * array or on the precision, so that a kept sequence has a meaning for other designs too. Where
 * bytes run out, zeros follow and the sequence ends after the call.
 */
#include "sg_fuzz.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MAX_OPERATIONS = 64, MAX_CALLS = 600, POOL = 16 };

double sg_fuzz_patience = 0.1;

static const uint8_t *bytes;
static size_t left;
static double pool[POOL]; /* real values that came out lately */
static unsigned pooled;

static uint8_t take(void)
{
    uint8_t value = 0;
    if (left > 0) {
        value = *bytes++;
        left--;
    }
    return value;
}

static unsigned take2(void)
{
    const unsigned low = take();
    return low | ((unsigned)take() << 8);
}

static uint32_t take4(void)
{
    const uint32_t low = take2();
    return low | ((uint32_t)take2() << 16);
}

static _Noreturn void fail(const sg_operation *op, const char *name, const char *what)
{
    fprintf(stderr, "servogen fuzz: %s: %s: %s\n", op->name, name, what);
    abort();
}

static int is_float(void)
{
    return sg_fuzzed.real_bytes == sizeof(float);
}

static double narrowed(double value)
{
    if (!is_float() || !isfinite(value)) {
        return value;
    }
    if (fabs(value) > FLT_MAX) {
        return copysign(INFINITY, value);
    }
    return (double)(float)value;
}

static double read_real(const void *at)
{
    float narrow;
    double wide;
    if (is_float()) {
        memcpy(&narrow, at, sizeof narrow);
        return narrow;
    }
    memcpy(&wide, at, sizeof wide);
    return wide;
}

static void write_real(void *at, double value)
{
    const float narrow = (float)narrowed(value);
    if (is_float()) {
        memcpy(at, &narrow, sizeof narrow);
    } else {
        memcpy(at, &value, sizeof value);
    }
}

static double neighbour(double value, double towards)
{
    if (is_float()) {
        return (double)nextafterf((float)value, (float)towards);
    }
    return nextafter(value, towards);
}

static double special(unsigned which)
{
    const double largest = is_float() ? (double)FLT_MAX : DBL_MAX;
    const double normal = is_float() ? (double)FLT_MIN : DBL_MIN;
    const double denormal = is_float() ? 1.401298464324817e-45 : 4.9406564584124654e-324;
    const double values[] = { NAN,      INFINITY,  0.0,       denormal, largest, normal, 0.25 * normal,
                              1.0,      -NAN,      -INFINITY, -0.0,     -denormal, -largest, -normal,
                              -0.25 * normal, -1.0 };
    return values[which % (sizeof values / sizeof values[0])];
}

static double raw_bits(void)
{
    const uint32_t high = take4();
    uint64_t wide = ((uint64_t)high << 32) | high;
    double value;
    float narrow;
    if (is_float()) {
        memcpy(&narrow, &high, sizeof narrow);
        return narrow;
    }
    memcpy(&value, &wide, sizeof value);
    return value;
}

static double bound_or_neighbour(const sg_port *port, unsigned which)
{
    const double low = narrowed(port->low);
    const double high = narrowed(port->high);
    switch (which % 6) {
    case 0: return low;
    case 1: return high;
    case 2: return neighbour(low, -INFINITY);
    case 3: return neighbour(high, INFINITY);
    case 4: return neighbour(low, INFINITY);
    default: return neighbour(high, -INFINITY);
    }
}

/* A value for a scalar, or the one that an array is made around. */
static double real_value(const sg_port *port, unsigned kind)
{
    const double middle = 0.5 * (port->low + port->high);
    const double half = 0.5 * (port->high - port->low);
    double share;
    double value;
    switch (kind % 12) {
    case 0: return bound_or_neighbour(port, take());
    case 1: return special(take());
    case 2: return raw_bits();
    case 3:
    case 4:
    case 5: /* what came out, or near it */
        value = pool[take() % POOL];
        return value + (half * (1.0 / 4096.0) * (double)(int8_t)take());
    case 6:
    case 7:
    case 8: /* mostly small */
        share = ((double)take2() / 32768.0) - 1.0;
        return middle + (half * share * share * share);
    default: share = ((double)take2() / 32767.5) - 1.0; return middle + (half * share);
    }
}

static void fill_array(const sg_port *port, unsigned char *at)
{
    const unsigned kind = take();
    const double range = port->high - port->low;
    const double start = real_value(port, kind >> 3);
    const double slope = (double)(int16_t)take2() / 32768.0;
    const double step = range * slope * slope * slope / port->size;
    const int mark = (int)(take() * (unsigned)port->size / 256u);
    uint32_t seed = 0x9E3779B9u ^ ((uint32_t)mark << 8) ^ kind;
    double value = start;
    if ((kind & 7u) == 7u) { /* one element only, the others as they were */
        write_real(at + ((size_t)mark * sg_fuzzed.real_bytes), start);
        return;
    }
    for (int i = 0; i < port->size; i++) {
        switch (kind & 7u) {
        case 0: value = start; break;
        case 1: value = (i < mark) ? start : (start + (range * slope)); break;
        case 2: /* noise */
            seed = (seed * 1664525u) + 1013904223u;
            value = start + (range * slope * ((double)(seed >> 8) / 16777216.0 - 0.5));
            break;
        case 3: value += (i < mark) ? step : -step; break; /* there and back */
        case 4: value += (i < mark) ? 0.0 : step; break;   /* stands, then goes */
        default: value += step; break;
        }
        if (value > port->high) { /* folded: a path stays inside, start decides if it begins there */
            value = (start <= port->high) ? port->high : value;
        }
        if (value < port->low) {
            value = (start >= port->low) ? port->low : value;
        }
        write_real(at + ((size_t)i * sg_fuzzed.real_bytes), value);
    }
}

static int32_t integer_value(const sg_port *port)
{
    const unsigned kind = take();
    const int64_t low = (int64_t)port->low;
    const int64_t high = (int64_t)port->high;
    switch (kind % 8) {
    case 0: return (int32_t)(low - 1);
    case 1: return (int32_t)(high + 1);
    case 2: return (int32_t)take4();
    case 3: return ((take() & 1) != 0) ? INT32_MAX : INT32_MIN;
    case 4: return (int32_t)low;
    case 5: return (int32_t)high;
    default: return (int32_t)(low + (int64_t)(take2() % (uint64_t)((high - low) + 1)));
    }
}

static void change(const sg_operation *op, unsigned char *in)
{
    const sg_port *port = &op->in[take() % op->n_in];
    unsigned char *at = in + port->offset;
    if (port->integer) {
        const int32_t value = integer_value(port);
        memcpy(at, &value, sizeof value);
    } else if (port->size > 0) {
        fill_array(port, at);
    } else {
        write_real(at, real_value(port, take()));
    }
}

static void rest(const sg_operation *op, unsigned char *in)
{
    memset(in, 0, op->in_bytes);
    for (int i = 0; i < op->n_in; i++) {
        if (op->in[i].integer) {
            const int32_t value = (int32_t)op->in[i].high;
            memcpy(in + op->in[i].offset, &value, sizeof value);
        }
    }
}

static void judge_port(const sg_operation *op, const sg_port *port, const unsigned char *out)
{
    const int count = (port->size > 0) ? port->size : 1;
    const size_t each = port->integer ? sizeof(int32_t) : sg_fuzzed.real_bytes;
    const double epsilon = is_float() ? (double)FLT_EPSILON : DBL_EPSILON;
    /* a value between two points may leave them by the rounding of a sum */
    const double room = port->integer ? 0.0 : 4.0 * epsilon * fmax(fabs(port->low), fabs(port->high));
    for (int i = 0; i < count; i++) {
        double value;
        if (port->integer) {
            int32_t whole;
            memcpy(&whole, out + port->offset + ((size_t)i * each), sizeof whole);
            value = whole;
        } else {
            value = read_real(out + port->offset + ((size_t)i * each));
        }
        if (!isfinite(value)) {
            fail(op, port->name, "not finite");
        }
        if (port->bounded && ((value < port->low - room) || (value > port->high + room))) {
            fail(op, port->name, "beyond its declared range");
        }
        if (!port->integer && (i == count - 1)) {
            pool[pooled++ % POOL] = value;
        }
    }
}

static void same_bits(const sg_operation *op, const unsigned char *one, const unsigned char *other)
{
    for (int i = 0; i < op->n_out; i++) {
        const sg_port *port = &op->out[i];
        const size_t each = port->integer ? sizeof(int32_t) : sg_fuzzed.real_bytes;
        const size_t size = each * (size_t)((port->size > 0) ? port->size : 1);
        if (memcmp(one + port->offset, other + port->offset, size) != 0) {
            fail(op, port->name, "differs between two instances given the same calls");
        }
    }
}

/* Memory of exactly this size: what goes beyond it is seen. */
static unsigned char *block(size_t size, int dirt)
{
    unsigned char *made = malloc((size > 0) ? size : 1);
    if (made == NULL) {
        abort();
    }
    memset(made, dirt, (size > 0) ? size : 1);
    return made;
}

/* One call on one instance; the input must come back as it went. */
static int call(const sg_operation *op, void *self, const unsigned char *in, unsigned char *out)
{
    unsigned char *given = block(op->in_bytes, 0);
    memcpy(given, in, op->in_bytes);
    const int status = op->call(self, given, out);
    if (memcmp(given, in, op->in_bytes) != 0) {
        fail(op, "in", "was written to");
    }
    free(given);
    if ((status < -1) || (status >= sg_fuzzed.n_statuses)) {
        fail(op, "status", "is none of the enumeration");
    }
    return status;
}

/* A third instance is called as it comes: the two must not notice. */
static void stranger(unsigned which, unsigned char *self, unsigned char **inputs)
{
    const int index = (int)(which % (unsigned)sg_fuzzed.n_operations);
    const sg_operation *op = &sg_fuzzed.operations[index];
    unsigned char *out = block(op->out_bytes, 0x5A);
    (void)call(op, self, inputs[index], out);
    for (int i = 0; i < op->n_out; i++) {
        judge_port(op, &op->out[i], out);
    }
    free(out);
}

/* The same call on two instances, now and then with a stranger's in between. */
static void turn(int index, unsigned char **self, unsigned char **inputs, int visited, unsigned which)
{
    const sg_operation *op = &sg_fuzzed.operations[index];
    const unsigned char *in = inputs[index];
    unsigned char *out[2] = { block(op->out_bytes, 0x00), block(op->out_bytes, 0xFF) };
    const int first = call(op, self[0], in, out[0]);
    if (visited) {
        stranger(which, self[2], inputs);
    }
    const int second = call(op, self[1], in, out[1]);
    if (first != second) {
        fail(op, "status", "differs between two instances given the same calls");
    }
    for (int i = 0; i < op->n_out; i++) {
        judge_port(op, &op->out[i], out[0]);
    }
    same_bits(op, out[0], out[1]);
    free(out[0]);
    free(out[1]);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    /* dirty in different ways: what init forgets makes the two differ */
    unsigned char *self[3] = { block(sg_fuzzed.bytes, 0x00), block(sg_fuzzed.bytes, 0xFF),
                               block(sg_fuzzed.bytes, 0xA5) };
    unsigned char *inputs[MAX_OPERATIONS];
    const clock_t begin = clock();
    bytes = data;
    left = size;
    memset(pool, 0, sizeof pool);
    pooled = 0;
    for (int i = 0; i < 3; i++) {
        sg_fuzzed.init(self[i]);
    }
    for (int i = 0; i < sg_fuzzed.n_operations; i++) {
        inputs[i] = block(sg_fuzzed.operations[i].in_bytes, 0);
        rest(&sg_fuzzed.operations[i], inputs[i]);
    }
    for (unsigned n = 0; (n < MAX_CALLS) && (left > 0);) {
        const unsigned head = take();
        const unsigned second = take();
        const int index = (int)((head & 63u) % (unsigned)sg_fuzzed.n_operations);
        const sg_operation *op = &sg_fuzzed.operations[index];
        const unsigned repeats = (op->n_in > 0) ? 1u : 1u + (((second >> 3) * (second >> 3)) / 4u);
        for (unsigned i = 0; (i < (second & 7u)) && (op->n_in > 0); i++) {
            change(op, inputs[index]);
        }
        for (unsigned i = 0; i < repeats; i++) {
            turn(index, self, inputs, (i == 0u) && ((head & 64u) != 0u), second);
        }
        n += repeats;
        if ((double)(clock() - begin) / CLOCKS_PER_SEC > sg_fuzz_patience) {
            break;
        }
    }
    for (int i = 0; i < sg_fuzzed.n_operations; i++) {
        free(inputs[i]);
    }
    for (int i = 0; i < 3; i++) {
        free(self[i]);
    }
    return 0;
}
