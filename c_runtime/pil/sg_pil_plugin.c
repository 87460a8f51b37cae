/* SPDX-License-Identifier: MIT */
/*
 * A plugin of QEMU's translator that counts what an emulated processor executes between two marks:
 * one row of counters for each call. Built with the host's compiler; no part of any firmware.
 *
 * It knows nothing of the instruction set. It is given a list of addresses, each with the column
 * to count in when the instruction there is executed, and adds one to column 0 for every
 * instruction. An address may stand in the list more than once.
 *
 * Arguments: map=FILE (lines "address column", both hexadecimal), columns=N, begin=ADDRESS and
 * end=ADDRESS (first instructions of the functions called right before and right after a call;
 * they are not counted themselves), rows=FILE (out: N uint64 in the host's order for each call).
 *
 * Debian ships no qemu-plugin.h. What follows up to the rule is declared as version 1 of the
 * interface has it (QEMU 7.2); QEMU says which versions it has when it loads the plugin.
 */
#include <inttypes.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SG_API 1

typedef uint64_t qemu_plugin_id_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
/* The head of the structure only; what follows in it is not used here. */
typedef struct {
    const char *target_name;
    struct {
        int min;
        int cur;
    } version;
} qemu_info_t;
enum { QEMU_PLUGIN_CB_NO_REGS = 0 };
enum { QEMU_PLUGIN_INLINE_ADD_U64 = 0 };

extern void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t id,
                                                  void (*cb)(qemu_plugin_id_t,
                                                             struct qemu_plugin_tb *));
extern void qemu_plugin_register_vcpu_tb_exec_cb(struct qemu_plugin_tb *tb,
                                                 void (*cb)(unsigned int, void *), int flags,
                                                 void *userdata);
extern void qemu_plugin_register_vcpu_tb_exec_inline(struct qemu_plugin_tb *tb, int op, void *ptr,
                                                     uint64_t imm);
extern size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *tb);
extern struct qemu_plugin_insn *qemu_plugin_tb_get_insn(const struct qemu_plugin_tb *tb,
                                                        size_t index);
extern uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn *insn);
extern void qemu_plugin_register_atexit_cb(qemu_plugin_id_t id,
                                           void (*cb)(qemu_plugin_id_t, void *), void *userdata);

__attribute__((visibility("default"))) int qemu_plugin_version = SG_API;
__attribute__((visibility("default"))) int qemu_plugin_install(qemu_plugin_id_t id,
                                                               const qemu_info_t *info, int argc,
                                                               char **argv);
/* ------------------------------------------------------------------------------------------- */

enum { MAX_COLUMNS = 32 };

typedef struct {
    uint64_t address;
    uint64_t column;
} sg_entry;

static uint64_t counters[MAX_COLUMNS];
static uint64_t columns, begin_address, end_address;
static int between;
static sg_entry *entries;
static size_t n_entries;
static FILE *rows;

static void at_begin(unsigned int cpu, void *unused)
{
    (void)cpu;
    (void)unused;
    memset(counters, 0, sizeof counters);
    between = 1;
}

static void at_end(unsigned int cpu, void *unused)
{
    (void)cpu;
    (void)unused;
    if (!between) {
        fprintf(stderr, "sg_pil_plugin: an end without a beginning\n");
        exit(1);
    }
    between = 0;
    if (fwrite(counters, sizeof counters[0], columns, rows) != columns) {
        fprintf(stderr, "sg_pil_plugin: the rows cannot be written\n");
        exit(1);
    }
}

static void at_exit(qemu_plugin_id_t id, void *unused)
{
    (void)id;
    (void)unused;
    fclose(rows);
}

/* The first entry at or behind the address; they are sorted. */
static size_t first_from(uint64_t address)
{
    size_t low = 0, high = n_entries;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if (entries[middle].address < address) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

/*
 * A block is executed from its first instruction to its last: an exception in its middle does not
 * happen in a call, and interrupts are off. Its sums are known when it is translated.
 */
static void translated(qemu_plugin_id_t id, struct qemu_plugin_tb *tb)
{
    uint64_t sums[MAX_COLUMNS] = {0};
    const size_t n = qemu_plugin_tb_n_insns(tb);
    const uint64_t first = qemu_plugin_insn_vaddr(qemu_plugin_tb_get_insn(tb, 0));
    (void)id;
    if (first == begin_address || first == end_address) {
        qemu_plugin_register_vcpu_tb_exec_cb(tb, first == begin_address ? at_begin : at_end,
                                             QEMU_PLUGIN_CB_NO_REGS, NULL);
        return;
    }
    sums[0] = n;
    for (size_t i = 0; i < n; i++) {
        const uint64_t address = qemu_plugin_insn_vaddr(qemu_plugin_tb_get_insn(tb, i));
        for (size_t e = first_from(address); e < n_entries && entries[e].address == address; e++) {
            sums[entries[e].column]++;
        }
    }
    for (uint64_t c = 0; c < columns; c++) {
        if (sums[c] != 0) {
            qemu_plugin_register_vcpu_tb_exec_inline(tb, QEMU_PLUGIN_INLINE_ADD_U64, &counters[c],
                                                     sums[c]);
        }
    }
}

static int by_address(const void *a, const void *b)
{
    const uint64_t x = ((const sg_entry *)a)->address, y = ((const sg_entry *)b)->address;
    return (x > y) - (x < y);
}

static int read_map(const char *path)
{
    size_t room = 0;
    uint64_t address, column;
    FILE *file = fopen(path, "r");
    if (file == NULL) {
        return 0;
    }
    while (fscanf(file, "%" SCNx64 " %" SCNx64, &address, &column) == 2) {
        if (column >= columns) {
            return 0;
        }
        if (n_entries == room) {
            room = 2 * room + 1024;
            entries = realloc(entries, room * sizeof *entries);
            if (entries == NULL) {
                return 0;
            }
        }
        entries[n_entries].address = address;
        entries[n_entries].column = column;
        n_entries++;
    }
    fclose(file);
    qsort(entries, n_entries, sizeof *entries, by_address);
    return 1;
}

static const char *argument(int argc, char **argv, const char *name)
{
    const size_t length = strlen(name);
    for (int i = 0; i < argc; i++) {
        if (strncmp(argv[i], name, length) == 0 && argv[i][length] == '=') {
            return argv[i] + length + 1;
        }
    }
    return NULL;
}

int qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t *info, int argc, char **argv)
{
    const char *map = argument(argc, argv, "map"), *width = argument(argc, argv, "columns");
    const char *from = argument(argc, argv, "begin"), *to = argument(argc, argv, "end");
    const char *out = argument(argc, argv, "rows");
    if (info->version.min > SG_API || info->version.cur < SG_API) {
        fprintf(stderr, "sg_pil_plugin: QEMU offers the plugin interface %d to %d, not %d\n",
                info->version.min, info->version.cur, SG_API);
        return 1;
    }
    if (map == NULL || width == NULL || from == NULL || to == NULL || out == NULL) {
        fprintf(stderr, "sg_pil_plugin: map, columns, begin, end and rows are wanted\n");
        return 1;
    }
    columns = strtoull(width, NULL, 16);
    begin_address = strtoull(from, NULL, 16);
    end_address = strtoull(to, NULL, 16);
    if (columns < 1 || columns > MAX_COLUMNS || !read_map(map)) {
        fprintf(stderr, "sg_pil_plugin: the map is not readable\n");
        return 1;
    }
    rows = fopen(out, "wb");
    if (rows == NULL) {
        fprintf(stderr, "sg_pil_plugin: the rows cannot be written\n");
        return 1;
    }
    qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
    qemu_plugin_register_atexit_cb(id, at_exit, NULL);
    return 0;
}
