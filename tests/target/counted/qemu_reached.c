/* A plugin of QEMU: which blocks of instructions an emulated program has run, and whether each was left by falling
 * through its end, by a branch, or both.
 *
 *     cc -shared -fPIC -DQEMU_PLUGIN_VERSION=1 qemu_reached.c -o qemu_reached.so
 *     qemu-system-arm ... -plugin qemu_reached.so,reached=FILE
 *
 * FILE becomes a line for each block: address, address behind it, 1 where it fell through, 1 where it branched. One
 * processor. The few declarations are those of QEMU's plugin interface, since few systems carry its header.
 */
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct qemu_plugin_tb;
struct qemu_plugin_insn;

typedef enum { QEMU_PLUGIN_CB_NO_REGS } qemu_plugin_cb_flags_t;
typedef void (*qemu_plugin_translated_fn)(uint64_t id, struct qemu_plugin_tb* block);
typedef void (*qemu_plugin_executed_fn)(unsigned int cpu, void* user);
typedef void (*qemu_plugin_ended_fn)(uint64_t id, void* user);

extern void qemu_plugin_register_vcpu_tb_trans_cb(uint64_t id, qemu_plugin_translated_fn translated);
extern void qemu_plugin_register_vcpu_tb_exec_cb(struct qemu_plugin_tb* block, qemu_plugin_executed_fn executed,
                                                 qemu_plugin_cb_flags_t flags, void* user);
extern void qemu_plugin_register_atexit_cb(uint64_t id, qemu_plugin_ended_fn ended, void* user);
extern size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb* block);
extern struct qemu_plugin_insn* qemu_plugin_tb_get_insn(const struct qemu_plugin_tb* block, size_t place);
extern uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn* instruction);
extern size_t qemu_plugin_insn_size(const struct qemu_plugin_insn* instruction);

int qemu_plugin_version = QEMU_PLUGIN_VERSION;
int qemu_plugin_install(uint64_t id, const void* info, int count, char** arguments);

typedef struct block {
    struct block* before;
    uint64_t from;
    uint64_t to;
    int run;
    int fell;
    int branched;
} block_t;

static block_t* last_made;
static block_t* last_run;

static void executed(unsigned int cpu, void* user)
{
    block_t* const block = user;
    (void)cpu;
    block->run = 1;
    if (last_run != NULL) {
        *((last_run->to == block->from) ? &last_run->fell : &last_run->branched) = 1;
    }
    last_run = block;
}

static void translated(uint64_t id, struct qemu_plugin_tb* tb)
{
    (void)id;
    const size_t count = qemu_plugin_tb_n_insns(tb);
    block_t* const block = calloc(1U, sizeof *block);
    if ((count > 0U) && (block != NULL)) {
        const struct qemu_plugin_insn* const last = qemu_plugin_tb_get_insn(tb, count - 1U);
        block->before = last_made;
        block->from = qemu_plugin_insn_vaddr(qemu_plugin_tb_get_insn(tb, 0U));
        block->to = qemu_plugin_insn_vaddr(last) + qemu_plugin_insn_size(last);
        last_made = block;
        qemu_plugin_register_vcpu_tb_exec_cb(tb, executed, QEMU_PLUGIN_CB_NO_REGS, block);
    }
}

static void ended(uint64_t id, void* user)
{
    (void)id;
    FILE* const file = fopen(user, "w");
    for (const block_t* block = last_made; (file != NULL) && (block != NULL); block = block->before) {
        if (block->run != 0) {
            (void)fprintf(file, "%llx %llx %d %d\n", (unsigned long long)block->from, (unsigned long long)block->to,
                          block->fell, block->branched);
        }
    }
    if (file != NULL) {
        (void)fclose(file);
    }
}

int qemu_plugin_install(uint64_t id, const void* info, int count, char** arguments)
{
    static const char option[] = "reached=";
    (void)info;
    if ((count != 1) || (strncmp(arguments[0], option, sizeof option - 1U) != 0)) {
        return 1;
    }
    const size_t bytes = strlen(arguments[0]) + 1U;
    char* const name = malloc(bytes);
    if (name == NULL) {
        return 1;
    }
    (void)memcpy(name, arguments[0], bytes);
    qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
    qemu_plugin_register_atexit_cb(id, ended, &name[sizeof option - 1U]);
    return 0;
}
