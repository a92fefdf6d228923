/* Runs test sources by name, in the order of the arguments: `ema_tests_f32 test_pid test_screw`. Without arguments it
 * runs all.
 *
 * The build generates ema_test_sources.def: one row EMA_TEST_SOURCE_ROW(name) per source. Exit codes: 0 all tests
 * passed, 1 a test failed or a source ran no test, 2 an unknown name, 3 no test source at all. */
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "unity.h"

enum { EXIT_PASSED = 0, EXIT_FAILED = 1, EXIT_UNKNOWN_NAME = 2, EXIT_NO_SOURCE = 3 };

typedef struct {
    const char* name;
    int (*run)(void);
    void (*set_up)(void);
    void (*tear_down)(void);
} test_source_t;

#define EMA_TEST_SOURCE_ROW(name)                                                                                      \
    int name##_main(void);                                                                                             \
    void name##_setUp(void);                                                                                           \
    void name##_tearDown(void);
#include "ema_test_sources.def"
#undef EMA_TEST_SOURCE_ROW

#define EMA_TEST_SOURCE_ROW(name) {#name, name##_main, name##_setUp, name##_tearDown},
/* The last row ends the table. */
static const test_source_t sources[] = {
#include "ema_test_sources.def"
    {NULL, NULL, NULL, NULL}};

static const test_source_t* running;

/* Unity calls these two around every test. */
void setUp(void)
{
    running->set_up();
}

void tearDown(void)
{
    running->tear_down();
}

static bool passes(const test_source_t* source)
{
    running = source;
    Unity.NumberOfTests = 0U;
    const int failures = source->run();
    const bool empty = (Unity.NumberOfTests == 0U);
    if (empty) {
        (void)fprintf(stderr, "%s ran no test: call RUN_TEST in its main\n", source->name);
    }
    return (failures == 0) && !empty;
}

static const test_source_t* find(const char* name)
{
    const test_source_t* source = sources;
    while ((source->name != NULL) && (strcmp(source->name, name) != 0)) {
        ++source;
    }
    return (source->name != NULL) ? source : NULL;
}

int main(int argc, char* argv[])
{
    bool passed = true;
    if (sources[0].name == NULL) {
        (void)fprintf(stderr, "the program holds no test source\n");
        return EXIT_NO_SOURCE;
    }
    for (int k = 1; k < argc; ++k) {
        if (find(argv[k]) == NULL) {
            (void)fprintf(stderr, "no test source `%s`: name a file of tests without its ending\n", argv[k]);
            return EXIT_UNKNOWN_NAME;
        }
    }
    for (int k = 1; k < argc; ++k) {
        passed = passes(find(argv[k])) && passed;
    }
    for (const test_source_t* source = sources; (argc < 2) && (source->name != NULL); ++source) {
        passed = passes(source) && passed;
    }
    return passed ? EXIT_PASSED : EXIT_FAILED;
}
