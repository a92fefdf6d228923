/* From reset to main on a Cortex-M with a floating-point unit, and from main back to the emulator.
 *
 * Standard output, files and the exit code go through semihosting: newlib's rdimon serves the C library, and main gets
 * the emulator's command line.
 */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#define CPACR (*(volatile uint32_t*)0xE000ED88U)
#define CPACR_FPU 0x00F00000U

#define SEMIHOSTING_GET_COMMAND_LINE 0x15U
#define ARGUMENTS_MAX 8
#define COMMAND_LINE_BYTES 256U

/* What a fault exits with. */
#define EXIT_FAULT 97

typedef void (*handler_t)(void);

/* Set by sections.ld. */
extern uint32_t ema_stack_top[];
extern const uint32_t ema_data_load[];
extern uint32_t ema_data_start[];
extern uint32_t ema_data_end[];
extern uint32_t ema_bss_start[];
extern uint32_t ema_bss_end[];

/* Opens newlib's standard streams; absent from programs that print nothing. */
extern void initialise_monitor_handles(void) __attribute__((weak));

int main(int argc, char* argv[]);
void ema_reset(void);
void ema_fault(void);
void ema_systick(void) __attribute__((weak, alias("ema_fault")));

static char command_line[COMMAND_LINE_BYTES];
static char* arguments[ARGUMENTS_MAX + 1];

static uint32_t semihosting(uint32_t operation, void* block)
{
    register uint32_t r0 __asm__("r0") = operation;
    register void* r1 __asm__("r1") = block;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

/* Cuts the emulator's command line at its blanks. */
static int read_arguments(void)
{
    struct {
        char* text;
        uint32_t bytes;
    } block = {command_line, sizeof command_line - 1U};
    int count = 0;
    if (semihosting(SEMIHOSTING_GET_COMMAND_LINE, &block) == 0U) {
        char* at = command_line;
        while ((*at != '\0') && (count < ARGUMENTS_MAX)) {
            arguments[count] = at;
            ++count;
            while ((*at != ' ') && (*at != '\0')) {
                ++at;
            }
            while (*at == ' ') {
                *at = '\0';
                ++at;
            }
        }
    }
    return count;
}

void ema_reset(void)
{
    CPACR |= CPACR_FPU;
    __asm__ volatile("dsb\n isb" ::: "memory");
    const uint32_t* from = ema_data_load;
    for (uint32_t* to = ema_data_start; to < ema_data_end; ++to) {
        *to = *from;
        ++from;
    }
    for (uint32_t* to = ema_bss_start; to < ema_bss_end; ++to) {
        *to = 0U;
    }
    if (initialise_monitor_handles != NULL) {
        initialise_monitor_handles();
    }
    const int count = read_arguments();
    exit(main(count, arguments));
}

void ema_fault(void)
{
    _Exit(EXIT_FAULT);
}

typedef union {
    uint32_t* stack;
    handler_t handler;
} vector_t;

#define SYSTEM_VECTORS 16

extern const vector_t ema_vectors[SYSTEM_VECTORS];
__attribute__((section(".vectors"), used)) const vector_t ema_vectors[SYSTEM_VECTORS] = {
    {.stack = ema_stack_top}, {.handler = ema_reset}, {.handler = ema_fault}, /* NMI */
    {.handler = ema_fault},                                                   /* hard fault */
    {.handler = ema_fault},                                                   /* memory management */
    {.handler = ema_fault},                                                   /* bus fault */
    {.handler = ema_fault},                                                   /* usage fault */
    {.handler = ema_fault},   {.handler = ema_fault}, {.handler = ema_fault},
    {.handler = ema_fault},   {.handler = ema_fault}, /* SVC */
    {.handler = ema_fault},                           /* debug monitor */
    {.handler = ema_fault},   {.handler = ema_fault}, /* PendSV */
    {.handler = ema_systick},
};
