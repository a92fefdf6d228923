/* A plugin of QEMU: counts the instructions of the emulated program, into a file that the program has mapped too
 * (ema_counter_shared.c).
 *
 *     cc -shared -fPIC -DQEMU_PLUGIN_VERSION=1 qemu_count.c -o qemu_count.so
 *     EMA_COUNTER=FILE qemu-riscv64 -plugin qemu_count.so,counter=FILE PROGRAM
 *
 * FILE has eight bytes or more. Counted where a block of instructions begins, so that a reading is right to the few of
 * its own block. The few declarations are those of QEMU's plugin interface, since few systems carry its header.
 */
#define _POSIX_C_SOURCE 200809L

#include <fcntl.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <sys/mman.h>

struct qemu_plugin_tb;

typedef enum { QEMU_PLUGIN_CB_NO_REGS } qemu_plugin_cb_flags_t;
typedef void (*qemu_plugin_translated_fn)(uint64_t id, struct qemu_plugin_tb* block);
typedef void (*qemu_plugin_executed_fn)(unsigned int cpu, void* user);

extern void qemu_plugin_register_vcpu_tb_trans_cb(uint64_t id, qemu_plugin_translated_fn translated);
extern void qemu_plugin_register_vcpu_tb_exec_cb(struct qemu_plugin_tb* block, qemu_plugin_executed_fn executed,
                                                 qemu_plugin_cb_flags_t flags, void* user);
extern size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb* block);

int qemu_plugin_version = QEMU_PLUGIN_VERSION;
int qemu_plugin_install(uint64_t id, const void* info, int count, char** arguments);

static volatile uint64_t* counted;

/* The number of a block's instructions travels as the pointer. */
static void executed(unsigned int cpu, void* user)
{
    (void)cpu;
    *counted += (uint64_t)(uintptr_t)user;
}

static void translated(uint64_t id, struct qemu_plugin_tb* block)
{
    (void)id;
    qemu_plugin_register_vcpu_tb_exec_cb(block, executed, QEMU_PLUGIN_CB_NO_REGS,
                                         (void*)(uintptr_t)qemu_plugin_tb_n_insns(block));
}

int qemu_plugin_install(uint64_t id, const void* info, int count, char** arguments)
{
    static const char option[] = "counter=";
    (void)info;
    if ((count != 1) || (strncmp(arguments[0], option, sizeof option - 1U) != 0)) {
        return 1;
    }
    const int file = open(&arguments[0][sizeof option - 1U], O_RDWR);
    void* const place =
        (file >= 0) ? mmap(NULL, sizeof *counted, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0) : MAP_FAILED;
    if (place == MAP_FAILED) {
        return 1;
    }
    counted = place;
    qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
    return 0;
}
